"""Stores the events of one attempt at a fit: those that no earlier attempt has stored.

Fits are deterministic, so an attempt that follows a lost one yields the same events again; they are counted, not
stored twice.
"""

import json

from breastrig.core.errors import Conflict, FitFailed, NotFound
from breastrig.storage.rows.events import append, event_of_kind
from breastrig.storage.rows.fits import FitRow
from breastrig.storage.storage import Storage
from breastrig.workflow.events import LAST_KINDS, Event, Started, event_json

OTHER_MODEL = "The model was exchanged after this fit had started; start the fit again."


class Superseded(Exception):
    """The fit was ended from outside or deleted, or another worker has claimed it."""


class EventWriter:
    """Writes the events of a fit as it was claimed, from the first one on, whichever are stored already."""

    def __init__(self, storage: Storage, fit: FitRow) -> None:
        self.fit = fit
        self._storage = storage
        self._written = 0

    def write(self, event: Event) -> None:
        """Stores the event if it is new.

        Raises Superseded when the fit has ended, was deleted, or is another worker's by now; FitFailed when it cannot
        go on as it began.
        """
        self._written += 1
        if event.kind not in LAST_KINDS and self._written <= self.fit.last_event:
            if isinstance(event, Started):
                self._check_model(event)
            return
        try:
            append(self._storage, self.fit.id, event_json(event), self.fit.attempt)
        except (NotFound, Conflict) as error:
            raise Superseded from error

    def _check_model(self, event: Started) -> None:
        known = event_of_kind(self._storage, self.fit.id, "started")
        if known is not None and json.loads(known.json).get("model_sha256") != event.model_sha256:
            raise FitFailed(OTHER_MODEL)
