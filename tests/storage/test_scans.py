"""Scans and files of fits as they come back."""

import pytest

from breastrig.cases.writing import put
from breastrig.core.errors import NotFound
from breastrig.core.picks import Picks
from breastrig.storage.documents.scans import StoredScan, get_landmarks, get_scan, picks_digest, put_landmarks
from breastrig.storage.files import fit_place, scan_place
from breastrig.storage.storage import Storage


def test_a_scan_comes_back_as_it_was_stored(storage: Storage, scan_id: str) -> None:
    assert get_scan(storage, scan_id) == StoredScan(
        scan_id,
        "2026-01-01T00:00:00.000Z",
        "ply",
        "ab" * 32,
        {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}},
    )


@pytest.mark.parametrize("name", ["nobody", "x" * 22, "", "..", "../../installation", "a\0b"])
def test_an_unknown_scan_is_not_found(storage: Storage, name: str) -> None:
    with pytest.raises(NotFound, match="no such scan"):
        get_scan(storage, name)


def test_landmarks_replace_those_that_were_seen(storage: Storage, scan_id: str) -> None:
    assert get_landmarks(storage, scan_id) == Picks({})
    one, two = (Picks({"nipple_L": [0.0, 1.0, float(z)]}, ("nipple_L",), {}) for z in range(2))
    assert put_landmarks(storage, scan_id, one)
    assert put_landmarks(storage, scan_id, two, picks_digest(one))
    assert not put_landmarks(storage, scan_id, one, picks_digest(one))
    assert get_landmarks(storage, scan_id) == two


def test_another_content_of_a_file_has_another_etag_and_what_is_not_there_is_not_found(
    storage: Storage, scan_id: str, fit_id: str
) -> None:
    files = storage.files
    assert files.find(fit_place(fit_id), "result.json") is None
    assert files.find(fit_place("nobody"), "result.json") is None
    assert files.find(scan_place(scan_id), "nothing.ply") is None
    seen = set()
    for content in (b"one", b"two"):
        put(files.fit(fit_id), "result.json", content)
        found = files.find(fit_place(fit_id), "result.json")
        assert found is not None
        with found.open() as file:
            assert file.read() == content
        seen.add(found.etag)
    assert len(seen) == 2
