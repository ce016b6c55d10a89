"""The patients of a data folder's rows as cases: one folder each, put in place whole, so that it can be repeated.

Documents are made of the rows, the log of the events; files are hard links, or copies where there are none.  What opens
links is nowhere in a case: it is handed back.
"""

import os
import shutil
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from sqlalchemy import Row, select

from breastrig.cases import layout
from breastrig.cases.case_folder import coming, sync_file
from breastrig.cases.documents import (
    CaseDocument,
    CutsDocument,
    ExpiresDocument,
    FitDocument,
    InkDocument,
    LinkDocument,
    PlanDocument,
    ProposalsDocument,
    ScanDocument,
    content_of,
)
from breastrig.cases.of_scans import landmark_document
from breastrig.cases.writing import LOCK, sync_folder
from breastrig.index.questions import LinkSecret
from breastrig.storage import schema
from breastrig.storage.files import fit_place, scan_place, share_place, upload_name
from breastrig.storage.rows.patients import scans_of_patient
from breastrig.storage.rows.scans import get_cuts, get_landmarks, get_scan
from breastrig.storage.storage import Storage


@dataclass
class BroughtOver:
    """What has been made; those that were there already are not counted."""

    cases: list[str] = field(default_factory=list)
    there: list[str] = field(default_factory=list)
    scans: int = 0
    fits: int = 0
    plans: int = 0  # versions
    links: int = 0
    secrets: list[LinkSecret] = field(default_factory=list)


def bring_over(
    storage: Storage,
    cases: Path,
    incoming: Path,
    wanted: Collection[str] | None = None,
    stopped: Callable[[], None] = lambda: None,
) -> BroughtOver:
    """Makes a case in the folder `cases` of each patient that has none there; `wanted` are codes, None: all.

    `incoming` is a folder on the same disk.  `stopped` is asked between patients.  Raises OSError; then the patients
    that were put in place are whole, and the others are made by the next call.
    """
    table, found = schema.patients, BroughtOver()
    with storage.database.reading() as rows:
        patients = rows.execute(select(table).order_by(table.c.position)).all()
    for patient in patients:
        stopped()
        if wanted is not None and patient.code not in wanted:
            continue
        if (cases / patient.id).exists():
            found.there.append(patient.id)
            continue
        with coming(incoming) as made:
            one = _Case(storage, patient, made, BroughtOver())
            one.write()
            for file in made.rglob("*"):
                if file.is_file() and file.stat().st_nlink == 1:  # what is linked is on the disk
                    sync_file(file)
            os.rename(made, cases / patient.id)
        sync_folder(cases)
        found.cases.append(patient.id)
        found.scans, found.fits = found.scans + one.found.scans, found.fits + one.found.fits
        found.plans, found.links = found.plans + one.found.plans, found.links + one.found.links
        found.secrets += one.found.secrets
    return found


@dataclass(frozen=True)
class _Case:
    storage: Storage
    patient: Row[Any]
    folder: Path
    found: BroughtOver

    def write(self) -> None:
        self._put(layout.CASE, CaseDocument(code=self.patient.code, created_at=self.patient.created_at))
        self._put(LOCK, b"")
        for scan_id in scans_of_patient(self.storage, self.patient.id):
            self._scan(scan_id)
        for number, row in enumerate(rows := self._rows(schema.plans, patient=self.patient.id), start=1):
            plan = PlanDocument.model_validate(row.json | {"version": row.version})
            name = layout.PLAN if number == len(rows) else f"{layout.PLANS}/{row.version:06}.json"
            self._put(name, plan)
            self.found.plans += 1

    def _scan(self, scan_id: str) -> None:
        row, part = get_scan(self.storage, scan_id), layout.scan_part(scan_id)
        file = upload_name(row.file_type)
        self._put(
            f"{part}/{layout.SCAN}",
            ScanDocument(created_at=row.created_at, sha256=row.sha256, facts=row.facts, file=file),
        )
        for name in (file, layout.MESH, layout.THUMBNAIL):
            self._link(scan_place(scan_id), name, f"{part}/{name}")
        picks, cuts = get_landmarks(self.storage, scan_id), get_cuts(self.storage, scan_id)
        if picks.points_mm:
            self._put(f"{part}/{layout.LANDMARKS}", landmark_document(picks))
        if cuts:
            self._put(f"{part}/{layout.CUTS}", CutsDocument(cuts=list(cuts)))
        for ink in self._rows(schema.ink, scan=scan_id):
            self._put(f"{part}/{layout.INK}", InkDocument.model_validate(ink.json | {"dropped": sorted(ink.dropped)}))
        for one in self._rows(schema.proposals, scan=scan_id):
            self._put(f"{part}/{layout.PROPOSALS}", ProposalsDocument(key=one.model_sha256, landmarks=one.json))
        for one in self._rows(schema.expiring_scans, scan=scan_id):
            self._put(f"{part}/{layout.EXPIRES}", ExpiresDocument(announced_at=one.announced_at))
        for fit in self._rows(schema.fits, scan=scan_id):
            self._fit(scan_id, fit)
        self.found.scans += 1

    def _fit(self, scan_id: str, row: Row[Any]) -> None:
        part, place = layout.fit_part(scan_id, row.id), fit_place(row.id)
        known = {name: getattr(row, name) for name in FitDocument.model_fields if hasattr(row, name)}
        once = next(iter(self._rows(schema.asked_once, fit=row.id)), None)
        hashes = {} if once is None else {"key_sha256": once.key_sha256, "request_sha256": once.request_sha256}
        asked = {"asked_at": row.created_at, "stance": row.asked_stance or row.stance}
        self._put(f"{part}/{layout.FIT}", FitDocument.model_validate(known | asked | hashes))
        lines = [event.json for event in self._rows(schema.events, fit=row.id)]
        if lines:
            self._put(f"{part}/{layout.LOG}", ("\n".join(lines) + "\n").encode())
        folder = self.storage.files.folder(place)
        for file in sorted(folder.iterdir()) if folder.is_dir() else ():
            if file.is_file() and file.name != layout.LOG:
                self._link(place, file.name, f"{part}/{file.name}")
        for link in self._rows(schema.shares, fit=row.id):
            self._link_of_fit(layout.link_part(scan_id, row.id, link.id), link)
        self.found.fits += 1

    def _link_of_fit(self, part: str, row: Row[Any]) -> None:
        shown = self.storage.files.folder(share_place(row.snapshot)) if row.snapshot else None
        number = 1 if shown is not None and shown.is_dir() else 0
        known = {name: getattr(row, name) for name in ("created_at", "expires_at", "revoked_at", "scan", "notes")}
        document = LinkDocument.model_validate(known | {"shown": number, "shown_at": row.snapshot_at})
        self._put(f"{part}/{layout.LINK}", document)
        if number and shown is not None:
            for file in sorted(each for each in shown.rglob("*") if each.is_file()):
                inside = file.relative_to(shown).as_posix()
                self._link(share_place(row.snapshot), inside, f"{part}/{layout.SHOWN}1/{inside}")
        self.found.links += 1
        counts = (row.wrong_passcodes, row.last_wrong_at, row.forgiven_passcodes)
        self.found.secrets.append(LinkSecret(row.id, row.token_sha256, row.passcode_hash, *counts))

    def _rows(self, table: Any, **where: str) -> list[Row[Any]]:
        """In the order in which they were made."""
        order = next((table.c[name] for name in ("position", "place", "id") if name in table.c), None)
        chosen = select(table).filter_by(**where)
        with self.storage.database.reading() as rows:
            return list(rows.execute(chosen if order is None else chosen.order_by(order)).all())

    def _put(self, name: str, document: BaseModel | bytes) -> None:
        target = self.folder / name
        target.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        target.write_bytes(document if isinstance(document, bytes) else content_of(document))
        target.chmod(0o600)

    def _link(self, place: str, name: str, target: str) -> None:
        """A file that never changes."""
        source, goal = self.storage.files.folder(place) / name, self.folder / target
        goal.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        try:
            os.link(source, goal)
        except FileNotFoundError:
            return
        except OSError:
            shutil.copyfile(source, goal)
            goal.chmod(0o600)
