"""Fits, and their queue: the oldest that waits is the next to run."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from breastrig.cases import fits, layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import FitDocument, content_of
from breastrig.cases.fits import ENDED as ENDED
from breastrig.cases.fits import NO_FIT
from breastrig.cases.fits import STATES as STATES
from breastrig.cases.layout import fit_part
from breastrig.cases.writing import put
from breastrig.core.errors import BadInput, Conflict, NotFound
from breastrig.index import questions
from breastrig.storage.documents.scans import Cuts, cuts_digest, get_cuts
from breastrig.storage.files import fit_place
from breastrig.storage.storage import Storage


class StoredFit(FitDocument):
    """A fit's request and its progress; `stance` is the decided one once the fit has started."""

    id: str
    scan: str
    asked_stance: str  # auto, standing, supine, prone
    state: str  # queued, running, done, failed, cancelled
    attempt: int  # how often a worker has started it
    last_event: int
    iterations: int
    numbers: dict[str, Any] | None  # the last iterated event without its nodes
    reason: str | None
    verdict: str | None  # good, uncalibrated, check or unusable; None before the end

    @property
    def created_at(self) -> str:
        return self.asked_at

    @property
    def ended(self) -> bool:
        return self.state in ENDED


@dataclass(frozen=True)
class Once:
    """A request that may be sent again without being executed again."""

    key_sha256: str
    request_sha256: str

    @classmethod
    def of(cls, key: str, request: str) -> "Once":
        """The key from the Idempotency-Key and the request's text."""
        key_sha256, request_sha256 = (hashlib.sha256(text.encode()).hexdigest() for text in (key, request))
        return cls(key_sha256, request_sha256)


def add_fit(storage: Storage, scan_id: str, fit_id: str, asked: FitDocument, once: Once | None = None) -> str:
    """Puts a fit of the scan at the end of the queue.

    Gives its id, or that of the fit which the same request, or the same prediction, has made before.  Raises
    NotFound when the scan is gone, BadInput when the key came with another request.
    """
    document = asked if once is None else asked.model_copy(update=asdict(once))
    made = storage.files.made(fit_place(fit_id))
    made.mkdir(mode=0o700, exist_ok=True)
    put(made, layout.FIT, content_of(document))
    case = storage.case_of_scan(scan_id)
    with storage.asking:  # of two that ask for the same one makes it
        same = _same_prediction(storage, asked)
        if same is None and once is not None:
            same = made_before(storage, once)
        if same is not None:
            return same
        with case.writing():
            case.check_scan(scan_id)
            case.put_folder(made, fit_part(scan_id, fit_id))
        storage.index.refresh(case.id)
    return fit_id


def made_before(storage: Storage, once: Once) -> str | None:
    """The fit that the same request has made; BadInput when the key came with another request."""
    found = storage.index.asked(questions.fit_of_key, once.key_sha256)
    if found is None:
        return None
    if found[1] != once.request_sha256:
        raise BadInput("This Idempotency-Key came with another request before; use a new key for a new fit.")
    return found[0]


def _same_prediction(storage: Storage, new: FitDocument) -> str | None:
    """An equal prediction that waits, runs or is done; failed and cancelled ones are made again."""
    source, stance = new.predicted_from, new.stance
    if source is None:
        return None
    asked = storage.index.asked(questions.predictions_of, source, stance)
    return next((fit.id for fit in _rows(storage, asked) if fit.state in STATES[:3]), None)


def get_fit(storage: Storage, fit_id: str) -> StoredFit:
    """The fit's row. Raises NotFound."""
    case, scan_id = storage.case_of_fit(fit_id)
    return _row(case, scan_id, fit_id)


def _row(case: CaseFolder, scan_id: str, fit_id: str) -> StoredFit:
    part = fit_part(scan_id, fit_id)
    document = case.read(f"{part}/{layout.FIT}", FitDocument)
    if document is None:
        raise NotFound(NO_FIT)
    folder = case.path / part
    lines = fits.events_after(folder)
    last = json.loads(lines[-1][1]) if lines else None
    started = json.loads(lines[0][1]) if lines else {}
    iterated = [line for _, line in lines if line.startswith(b'{"kind":"iterated"')]
    numbers = json.loads(iterated[-1]) if iterated else None
    state = fits.state_of(folder, document, last)
    end = last if last is not None and last["kind"] in ENDED else {}
    progress = {
        "id": fit_id,
        "scan": scan_id,
        "stance": started.get("stance", document.stance),
        "asked_stance": document.stance,
        "state": state,
        "attempt": fits.starts_of(folder),
        "last_event": len(lines),
        "iterations": len(iterated),
        "numbers": numbers and {k: v for k, v in numbers.items() if k not in ("kind", "nodes", "modes")},
        "reason": fits.reason_of(folder, document, end),
        "verdict": (end.get("result", {}).get("verdict") or {}).get("level"),
    }
    return StoredFit.model_construct(**dict(document) | progress)


def shown_cuts(storage: Storage, fit: StoredFit) -> Cuts:
    """The present cuts by hand of the fit's scan; none for a prediction, for its scan was cut before.

    Raises Conflict when that scan is cut otherwise by now.
    """
    cuts = get_cuts(storage, fit.scan)
    if fit.predicted_from is None:
        return cuts
    if cuts_digest(cuts) != cuts_digest(fit.cuts):
        raise Conflict("The scan was cut after this was predicted from it; fit it again, and predict from that fit.")
    return ()


def fits_of_scan(storage: Storage, scan_id: str) -> list[str]:
    try:
        return fits.fit_ids(storage.case_of_scan(scan_id), scan_id)
    except NotFound:
        return []


def fits_page(
    storage: Storage, limit: int, before: int | None = None, scan_id: str | None = None
) -> tuple[list[StoredFit], int | None]:
    """Fits, or those of a scan, the newest first, and where the next page goes on (None: there is none)."""
    groups = storage.groups_in_reach()
    ids, more = storage.index.asked(questions.fits_page, limit, before, scan_id, groups)
    return list(_rows(storage, ids)), more


def newest_done(storage: Storage, scan_id: str) -> StoredFit | None:
    """The fit of the scan that was asked for last among those that are done; no prediction.

    The folders say so: the index hears of an end a moment later than those who follow the fit.
    """
    found = storage.index.asked(questions.perhaps_done, scan_id)
    return next((fit for fit in _rows(storage, found) if fit.state == "done"), None)


def _rows(storage: Storage, ids: Sequence[str]) -> Iterator[StoredFit]:
    """The rows of the fits that exist."""
    for fit_id in ids:
        with suppress(NotFound):
            yield get_fit(storage, fit_id)
