"""A place in the queue that is told, and a share of the queue that nobody exceeds."""

from dataclasses import replace

import pytest
from helpers import fake_fit
from helpers.waiting import ended, until

from breastrig.cases.documents import FitDocument
from breastrig.core.errors import TooMany
from breastrig.execution.limits import UploadLimits
from breastrig.execution.pool import client_key
from breastrig.service.service import Service
from breastrig.storage.documents.fits import Once, get_fit
from breastrig.storage.storage import utc_now


def ask(service: Service, scan_id: str, client: str | None = None, **more: object) -> str:
    return service.add_fit(scan_id, FitDocument(asked_at=utc_now(), preset="paper"), client=client, **more)


def test_nobody_has_more_fits_waiting_than_a_share(serving, scan_id: str) -> None:
    with serving(fake_fit.patient, workers=1, waiting_per_client=2) as service:
        running = ask(service, scan_id, "a")
        until(lambda: get_fit(service.storage, running).state == "running", "the first to run")
        once = Once.of("key", "request")
        waiting = [ask(service, scan_id, "a"), ask(service, scan_id, "a", once=once)]
        with pytest.raises(TooMany, match="2 of your fits are waiting already") as caught:
            ask(service, scan_id, "a")
        assert caught.value.retry_after_s > 0
        assert ask(service, scan_id, "a", once=once) == waiting[1]  # asks for nothing new
        ask(service, scan_id, "b")
        ask(service, scan_id)
        service.cancel_fit(waiting[0])
        ask(service, scan_id, "a")
        with pytest.raises(TooMany):
            ask(service, scan_id, "a")


def test_a_fit_is_no_task_of_the_client_whose_request_starts_it(serving, scan_id: str) -> None:
    uploads = replace(UploadLimits(), waiting_per_client=0)
    with serving(fake_fit.quick, uploads=uploads) as service:
        before = client_key.set("a")
        try:
            fits = [ask(service, scan_id, "a") for _ in range(3)]
        finally:
            client_key.reset(before)
        assert [ended(service, fit).state for fit in fits] == ["done"] * 3


def test_a_refused_fit_leaves_no_folder_and_takes_no_place(serving, scan_id: str) -> None:
    with serving(fake_fit.quick, workers=1, waiting_per_client=0) as service:
        with pytest.raises(TooMany):
            ask(service, scan_id, "a")
        assert not list(service.storage.root.rglob("fit.json"))
        assert ended(service, ask(service, scan_id)).state == "done"
