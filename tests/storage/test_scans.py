import pytest
from helpers.on_disk import bytes_below
from helpers.rows import add_waiting_fit

from breastrig.core.errors import NotFound
from breastrig.core.picks import Picks
from breastrig.storage.deletion import delete_rows, remove_files
from breastrig.storage.rows.events import append
from breastrig.storage.rows.fits import get_fit
from breastrig.storage.rows.scans import get_landmarks, get_scan, put_landmarks, scan_ids
from breastrig.storage.storage import Storage


def test_a_scan_comes_back_as_it_was_stored(storage: Storage, scan_id: str) -> None:
    row = get_scan(storage, scan_id)
    assert (row.file_type, row.facts["unit"]) == ("ply", "mm")
    assert scan_ids(storage) == {scan_id}


def test_an_unknown_scan_is_not_found(storage: Storage) -> None:
    with pytest.raises(NotFound, match="no such scan"):
        get_scan(storage, "nobody")
    with pytest.raises(NotFound, match="no such scan"):
        put_landmarks(storage, "nobody", Picks({}))
    assert delete_rows(storage, "nobody") == []


def test_landmarks_replace_those_before(storage: Storage, scan_id: str) -> None:
    assert get_landmarks(storage, scan_id) == Picks({}, ())
    for picks in (
        Picks({"nipple_L": [1.0, 2.0, 3.0]}, ("nipple_L",)),
        Picks({"nipple_R": [1.0, 2.0, 3.0]}),
        Picks({"nipple_R": [1.0, 2.0, 3.0]}, ("nipple_R",)),
        Picks({"nipple_R": [1.0, 2.0, 3.0]}, (), {"nipple_R": 0.4}),
    ):
        put_landmarks(storage, scan_id, picks)
        assert get_landmarks(storage, scan_id) == picks


def test_deleting_a_scan_leaves_no_row_and_no_byte_of_it(storage: Storage, scan_id: str) -> None:
    put_landmarks(storage, scan_id, Picks({"a_landmark_with_a_rare_name": [1.0, 2.0, 3.0]}))
    add_waiting_fit(storage, scan_id, "fit-1")
    append(storage, "fit-1", {"kind": "failed", "reason": "a reason with a rare word: xylophone"})
    assert delete_rows(storage, scan_id) == ["fit-1"]
    assert remove_files(storage, scan_id) == []
    with pytest.raises(NotFound):
        get_fit(storage, "fit-1")
    left = bytes_below(storage.root, "breastrig.sqlite3*")
    for trace in (b"a_landmark_with_a_rare_name", b"xylophone", b"scan-1", b"fit-1"):
        assert trace not in left
