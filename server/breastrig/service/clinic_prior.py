"""The prior that a service learns from its own fits, where its owner has asked for that (decision 0027).

At night, at a start, on demand, and a minute after each deletion it is made anew of the fits that there are.  With a
deletion all that was learned goes at once, so that who is deleted is in no file any more; for that minute fits have the
built-in prior.
"""

import json
import logging
import threading
from collections import defaultdict
from contextlib import suppress
from datetime import datetime
from typing import Any

from breastrig.core import wall_clock
from breastrig.core.errors import Conflict, NotFound
from breastrig.execution.pool import Lane
from breastrig.files.result import BODY
from breastrig.service.kept_models import KeptModels
from breastrig.storage.files import MODELS, fit_place
from breastrig.storage.rows.cohort_fits import cohort_fits
from breastrig.storage.storage import Storage, iso_utc
from breastrig.workflow.jobs import CohortJob
from breastrig.workflow.tasks import learn_prior

PRIORS = "priors.json"  # in the place of the models: by hash of the model; empty: none
NIGHT = 3  # o'clock, of the machine's time
WALL_S = 60.0  # a thousand fits take some seconds
OFF = "This service learns no prior; start it with --learn-prior."

log = logging.getLogger(__name__)


def kept_prior(storage: Storage, model_sha256: str) -> bytes | None:
    """What the service has learned of bodies for the model with that hash."""
    with storage.files.reading(MODELS, [PRIORS]) as folder, suppress(FileNotFoundError):
        found = (folder / PRIORS).read_bytes()
        text = json.loads(found).get(model_sha256) if found else None
        return None if text is None else str(text).encode()
    return None


def forget_priors(storage: Storage) -> None:
    """Nothing of them is left.  Raises OSError."""
    if storage.files.find(MODELS, PRIORS) is not None:
        storage.files.write(MODELS, PRIORS, b"")


class ClinicPrior:
    """May be called from any thread."""

    def __init__(self, storage: Storage, lane: Lane, models: KeptModels, learns: bool) -> None:
        self._storage, self._lane, self._models, self.learns = storage, lane, models, learns
        self._changes = 0  # of what there is to learn from
        self._learned_changes = -1
        self._learned_at: datetime | None = None
        self._lock, self._learning = threading.Lock(), threading.Lock()
        self._found: dict[str, list[dict[str, Any]]] = {}

    def forget(self) -> None:
        """Somebody is gone: what was learned with her is no more."""
        with self._lock:
            self._changes += 1
            self._found = {}
            forget_priors(self._storage)

    def look(self) -> None:
        """Learns where it is time to, and keeps nothing where nobody wants it."""
        try:
            if self.learns and (self._learned_changes != self._changes or self._is_night()):
                self._learn()
            elif not self.learns and self._learned_changes < 0:
                self.forget()
                self._learned_changes = self._changes
        except Exception:
            log.exception("the prior cannot be learned")

    def learn(self) -> None:
        """Now.  Raises Conflict where the service learns nothing."""
        if not self.learns:
            raise Conflict(OFF)
        self._learn()

    @property
    def learned_at(self) -> str | None:
        return None if self._learned_at is None else iso_utc(self._learned_at)

    def stances(self, model_sha256: str) -> list[dict[str, Any]]:
        """Of how many patients each stance's prior is, and how much closer it foretells one; none: nobody."""
        return self._found.get(model_sha256, [])

    def _is_night(self) -> bool:
        now = wall_clock.now().astimezone()
        return now.hour == NIGHT and (self._learned_at is None or self._learned_at.astimezone().date() != now.date())

    def _learn(self) -> None:
        with self._learning:
            changes = self._changes
            bodies: dict[str, list[tuple[str, str, bytes]]] = defaultdict(list)
            for fit in cohort_fits(self._storage):
                with suppress(OSError, NotFound), self._storage.files.reading(fit_place(fit.id), [BODY]) as folder:
                    content = (folder / BODY).read_bytes()
                    bodies[self._models.sha256_of(fit.id)].append((fit.patient, fit.stance, content))
            found = {}
            for sha256 in self._models.hashes:
                with self._models.at_hand(sha256) as model:
                    job = CohortJob(tuple(bodies[sha256]), model)
                    found[sha256] = self._lane.result(learn_prior, (job,), WALL_S)
            with self._lock:
                if changes != self._changes:
                    return  # somebody was deleted meanwhile; the next look learns without her
                texts = {sha256: content.decode() for sha256, (content, _) in found.items() if content}
                self._storage.files.write(MODELS, PRIORS, json.dumps(texts).encode() if texts else b"")
                self._found = {sha256: stances for sha256, (_, stances) in found.items()}
                self._learned_at, self._learned_changes = wall_clock.now(), changes
        log.info("the prior is of %d scans now", sum(each["patients"] for s in self._found.values() for each in s))
