"""Fits whose ends the index has not heard of yet: their worker is another process."""

from helpers.stored_fits import add_waiting_fit, named

from breastrig.cases.documents import FitDocument
from breastrig.cases.fits import claimed
from breastrig.storage.documents.fits import add_fit, newest_done
from breastrig.storage.storage import Storage


def end(storage: Storage, fit_id: str, kind: str) -> None:
    """As a worker does; the service's process looks at its case some moments later."""
    case, scan_id = storage.case_of_fit(fit_id)
    with claimed(case, scan_id, fit_id) as claim:
        assert claim is not None
        claim.end({"kind": kind})


def test_a_fit_counts_as_done_from_its_last_event_on(storage: Storage, scan_id: str, fit_id: str) -> None:
    assert newest_done(storage, scan_id) is None
    add_waiting_fit(storage, scan_id, named("fit-2"))
    end(storage, fit_id, "done")
    found = newest_done(storage, scan_id)
    assert found is not None
    assert found.id == fit_id
    end(storage, named("fit-2"), "failed")
    assert newest_done(storage, scan_id) == found


def test_a_prediction_that_has_just_failed_is_made_again(storage: Storage, scan_id: str, fit_id: str) -> None:
    wish = FitDocument(asked_at="2026-01-01T00:00:02.000Z", stance="supine", predicted_from=fit_id)
    first, second, third = (named(f"prediction-{number}") for number in range(3))
    assert add_fit(storage, scan_id, first, wish) == first
    assert add_fit(storage, scan_id, second, wish) == first
    end(storage, first, "failed")
    assert add_fit(storage, scan_id, second, wish) == second
    end(storage, second, "done")
    assert add_fit(storage, scan_id, third, wish) == second
