import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any

import pytest
from helpers import fake_fit, fake_proposals
from helpers.waiting import PATIENCE_S, until

from breastrig.cases import of_scans
from breastrig.core.errors import BreastRigError, FitFailed, NotFound
from breastrig.execution.limits import UploadLimits
from breastrig.service.scans.scan_search import Proposals
from breastrig.storage.documents.scans import get_scan
from breastrig.storage.storage import Storage

pytestmark = pytest.mark.long

FOUND = {
    "nipple_L": {
        "point": [70.0, 350.0, 120.0],
        "confidence": 0.5,
        "on_scan": True,
        "error_mm": 16.0,
        "reason": "areola seen",
    },
    "umbilicus": {
        "point": [70.0, 350.0, 120.0],
        "confidence": 0.5,
        "on_scan": False,
        "error_mm": 16.0,
        "to_skin_mm": 105.0,
        "reason": None,
    },
}


def kept(storage: Storage, scan_id: str, model_sha256: str) -> dict | None:
    """The proposals that are in the case; None where it is gone."""
    with suppress(NotFound):
        return of_scans.get_proposals(storage.case_of_scan(scan_id), scan_id, model_sha256)
    return None


def times_made(storage: Storage, scan_id: str) -> int:
    return len((storage.files.scan(scan_id) / "proposed").read_text().splitlines())


@contextmanager
def held(storage: Storage, scan_id: str) -> Iterator[None]:
    """Searches on the scan do not end before this does."""
    file = storage.files.scan(scan_id) / "held"
    file.touch()
    yield
    file.unlink()


def test_whoever_asks_gets_one_computation_which_outlives_the_server(serving, storage: Storage, scan_id: str) -> None:
    scan = get_scan(storage, scan_id)
    with serving(fake_fit.quick) as service:
        answers: list[object] = []
        threads = [
            threading.Thread(target=lambda: answers.append(service.proposals.of(scan, "a" * 64, PATIENCE_S)))
            for _ in range(5)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert answers == [FOUND] * 5
        assert service.proposals.of(scan, "a" * 64, PATIENCE_S) == FOUND
        until(lambda: kept(storage, scan_id, "a" * 64) is not None, "the row")
    with serving(fake_fit.quick, proposer=fake_proposals.failing) as service:
        assert service.proposals.of(scan, "a" * 64, 0.0) == FOUND
    assert times_made(storage, scan_id) == 1


def test_another_model_proposes_anew(serving, storage: Storage, scan_id: str) -> None:
    scan = get_scan(storage, scan_id)
    with serving(fake_fit.quick) as service:
        for made, model in enumerate(("a" * 64, "b" * 64), start=1):
            assert service.proposals.of(scan, model, PATIENCE_S) == FOUND
            until(lambda model=model: kept(storage, scan_id, model) is not None, "the row")
            assert times_made(storage, scan_id) == made
        assert kept(storage, scan_id, "a" * 64) is None


def test_another_model_does_not_get_what_is_being_found_for_the_first(serving, storage: Storage, scan_id: str) -> None:
    scan = get_scan(storage, scan_id)
    with serving(fake_fit.quick) as service:
        with held(storage, scan_id):
            assert service.proposals.of(scan, "a" * 64, 0.0) is None
        assert service.proposals.of(scan, "b" * 64, PATIENCE_S) == FOUND
        until(lambda: times_made(storage, scan_id) == 2, "the other model's search")


def test_who_does_not_wait_finds_them_later(serving, storage: Storage, scan_id: str) -> None:
    scan = get_scan(storage, scan_id)
    with serving(fake_fit.quick) as service:
        with held(storage, scan_id):
            assert service.proposals.of(scan, "a" * 64, 0.0) is None
        until(lambda: service.proposals.of(scan, "a" * 64, 0.0) == FOUND, "the proposals")
    assert times_made(storage, scan_id) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("proposer", "sentence", "wall_s"),
    [
        (fake_proposals.failing, "The model found no skin near it; place three landmarks.", PATIENCE_S),
        (fake_proposals.broken, "Finding landmarks on this scan broke", PATIENCE_S),
        (fake_proposals.dying, "Finding landmarks on this scan broke", PATIENCE_S),
        (fake_proposals.hanging, "Finding landmarks took longer than 0.3 s", 0.3),
    ],
)
def test_a_failure_is_a_sentence_and_is_not_kept(
    serving, storage: Storage, scan_id: str, proposer, sentence: str, wall_s: float
) -> None:
    scan = get_scan(storage, scan_id)
    with serving(fake_fit.quick, proposer=proposer, uploads=replace(UploadLimits(), wall_s=wall_s)) as service:
        for _ in range(2):
            with pytest.raises(FitFailed, match=sentence):
                service.proposals.of(scan, "a" * 64, PATIENCE_S)
        assert service.proposals._running == {}
    assert kept(storage, scan_id, "a" * 64) is None


def test_deleting_the_scan_ends_the_search_and_removes_what_was_found(serving, storage: Storage, scan_id: str) -> None:
    scan = get_scan(storage, scan_id)
    with serving(fake_fit.quick, proposer=fake_proposals.hanging) as service:
        raised: list[BreastRigError] = []

        def ask() -> None:
            try:
                service.proposals.of(scan, "a" * 64, PATIENCE_S)
            except BreastRigError as error:
                raised.append(error)

        thread = threading.Thread(target=ask)
        thread.start()
        until(lambda: (scan_id, "a" * 64) in service.proposals._running, "the search")
        service.delete_scan(scan_id)
        thread.join(timeout=PATIENCE_S)
        assert [type(error) for error in raised] == [NotFound]
        assert kept(storage, scan_id, "a" * 64) is None


def test_who_asks_while_a_search_is_being_stored_begins_no_second_one(
    serving, storage: Storage, scan_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = get_scan(storage, scan_id)
    with serving(fake_fit.quick) as service:
        stored = Proposals._stored
        lookups = []

        def stored_just_after_the_lookup(self: Proposals, scan_id: str, variant: str) -> dict[str, Any] | None:
            found = stored(self, scan_id, variant)
            lookups.append(found)
            if len(lookups) == 2:  # of the second caller
                until(lambda: kept(storage, scan_id, "a" * 64) is not None, "the row")
                until(lambda: not self._running, "the end of the search")
            return found

        monkeypatch.setattr(Proposals, "_stored", stored_just_after_the_lookup)
        with held(storage, scan_id):
            assert service.proposals.of(scan, "a" * 64, 0.0) is None
        assert service.proposals.of(scan, "a" * 64, PATIENCE_S) == FOUND
        assert service.proposals.of(scan, "a" * 64, PATIENCE_S) == FOUND
    assert times_made(storage, scan_id) == 1
