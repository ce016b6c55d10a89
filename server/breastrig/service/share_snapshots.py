"""Share links with the files that they show: made with the link, again when the owner asks, removed when it is over.

They are made in a process of its own from the fit, the plan and the cuts as they stand, in `incoming`, so nothing of
what is interrupted stays.
"""

import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from breastrig.core.errors import BadInput, Conflict
from breastrig.execution.pool import TaskQueue
from breastrig.languages.catalogue import ENGLISH
from breastrig.service.failed_tasks import explained
from breastrig.service.kept_models import KeptModels
from breastrig.service.plans import Plans
from breastrig.service.reports import Reports
from breastrig.storage.documents.fits import StoredFit, get_fit, shown_cuts
from breastrig.storage.documents.scans import get_scan
from breastrig.storage.documents.shares import (
    StoredShare,
    add_share,
    end_snapshots,
    get_share,
    replace_snapshot,
    revoke_share,
)
from breastrig.storage.files import fit_place, scan_place, share_place, upload_name
from breastrig.storage.folders import new_id
from breastrig.storage.storage import Storage, utc_now
from breastrig.use.reports.share_snapshot import SnapshotJob, write_snapshot

WALL_S = 180.0  # the example takes three seconds, most for the report; a slow or busy machine with huge scans many

log = logging.getLogger(__name__)


class ShareSnapshots:
    """The links of all fits.  May be called from any thread."""

    def __init__(
        self, storage: Storage, processes: TaskQueue, plans: Plans, reports: Reports, models: KeptModels
    ) -> None:
        self._storage = storage
        self._processes = processes
        self._plans = plans
        self._reports = reports
        self._models = models

    def add(self, share: StoredShare, token_sha256: str, language: str = ENGLISH) -> StoredShare:
        """Keeps the link with what it shows.

        Raises a BreastRigError with a sentence, NotFound when the fit was deleted meanwhile, OSError for a full disk.
        """
        fit = get_fit(self._storage, share.fit)
        if fit.state != "done":
            raise Conflict(f"This fit has no result to share: it is {fit.state}.")
        if fit.predicted_from is not None and share.scan != "plain":
            raise BadInput(
                "This body is predicted, not scanned: it has one skin, without colours; share it as `plain`."
            )
        with self._taken(fit, share, language) as snapshot:
            made = replace(share, snapshot=snapshot, snapshot_at=utc_now())
            return add_share(self._storage, made, token_sha256)

    def refresh(self, fit_id: str, share_id: str, language: str = ENGLISH) -> StoredShare:
        """The link shows what stands now.  Raises likewise, and Conflict when it is over."""
        share, fit = get_share(self._storage, fit_id, share_id), get_fit(self._storage, fit_id)
        if not share.is_valid(utc_now()):
            raise Conflict("This link is over; make a new one.")
        with self._taken(fit, share, language) as snapshot:
            replace_snapshot(self._storage, share, snapshot)
        return get_share(self._storage, fit_id, share_id)

    def revoke(self, fit_id: str, share_id: str) -> None:
        """Closes the link and removes what it showed; files that cannot be removed are tried again."""
        try:
            revoke_share(self._storage, fit_id, share_id)
        except OSError as left:
            log.error("what a link showed cannot be removed yet: %s", left.strerror)

    def end_expired(self) -> None:
        """Removes what links showed that are over by now."""
        end_snapshots(self._storage, utc_now())

    @contextmanager
    def _taken(self, fit: StoredFit, share: StoredShare, language: str) -> Iterator[str]:
        """A new snapshot; the block puts it into the case, or nothing is left of it."""
        snapshot = new_id()
        place = share_place(snapshot)
        try:
            self._storage.files.make(place)
            self._write(place, fit, share, language)
            yield snapshot
        except BaseException:
            self._storage.discard(place)
            raise

    def _write(self, place: str, fit: StoredFit, share: StoredShare, language: str) -> None:
        files, scan = self._storage.files, get_scan(self._storage, fit.scan)
        planned, cuts = self._plans.of_fit(fit.id), shown_cuts(self._storage, fit)
        plan: dict[str, Any] = json.loads(self._plans.laid(planned))
        stored = upload_name(scan.file_type)
        with (
            explained("Making this link", WALL_S, "try again, or simplify the scan", self._storage, [fit.id]),
            self._models.of_fits([fit.id]) as model,
        ):
            job = SnapshotJob(
                fit=files.folder(fit_place(fit.id)),
                plan=plan,
                items=planned.plan.items,
                identity=replace(self._reports.identity([fit]), code=""),
                out=files.made(place),
                scan=files.folder(scan_place(scan.id)) / stored if share.scan == "full" else None,
                file_type=scan.file_type,
                shows_scan=share.scan != "none",
                has_notes=share.notes,
                cuts=cuts,
                model=model,
                language=language,
            )
            self._processes.result(write_snapshot, (job,), WALL_S)
