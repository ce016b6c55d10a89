"""Patients of version 0.2.0, which were rows, as cases: a folder each, put in place whole, so that it can be repeated.

Documents are made of the rows, the log of the events; files are hard links, or copies where there are none.  What opens
links is nowhere in a case: it goes into the index.
"""

import json
import logging
import os
import shutil
import sqlite3
from collections.abc import Collection
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel

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
from breastrig.core.errors import BadSettings
from breastrig.core.picks import Picks
from breastrig.index.file import is_damage
from breastrig.index.questions import LinkSecret, end_session, put_secret
from breastrig.storage.files import fit_place, scan_place, share_place, upload_name
from breastrig.storage.storage import Storage

OLD, RESERVE = "breastrig.sqlite3", "reserve"
KINDS = ("scans", "fits", "shares")

log = logging.getLogger(__name__)


def _rows(old: sqlite3.Connection, table: str, order: str = "rowid", **where: str) -> list[sqlite3.Row]:
    wanted = " AND ".join(f"{name} = ?" for name in where) or "1"
    return old.execute(f"SELECT * FROM {table} WHERE {wanted} ORDER BY {order}", tuple(where.values())).fetchall()


def is_early(root: Path) -> bool:
    """Whether the data folder has patients of an early version, who have not been brought over."""
    return (root / OLD).is_file()


def take_over(storage: Storage) -> None:
    """Brings the patients of an early version's data folder over, once; may be interrupted and repeated.

    Raises BadSettings when its database is damaged, or not all of them came over; then the early version's files stay
    as they are.
    """
    root, old = storage.root, storage.root / OLD
    if not is_early(root):
        return
    (root / RESERVE).unlink(missing_ok=True)  # room for the documents
    try:
        patients = _take_over(storage)
    except sqlite3.Error as error:
        if not is_damage(error):
            raise
        raise BadSettings(
            f"The database {old} of an earlier version is damaged; put a copy of the data folder in its place, or "
            "choose another with --data."
        ) from error
    for name in (*KINDS, layout.RUBBISH):  # what others have put there stays
        for entry in (root / name).iterdir() if (root / name).is_dir() else ():
            of_kind, _, name_there = entry.name.rpartition(".")
            if layout.ID.fullmatch(name_there) and of_kind in (KINDS if name == layout.RUBBISH else ("",)):
                shutil.rmtree(entry, ignore_errors=True)
    for name in KINDS:
        with suppress(OSError):
            (root / name).rmdir()
    for name in (f"{OLD}-wal", f"{OLD}-shm", OLD):
        (root / name).unlink(missing_ok=True)
    log.warning("%d patients of an earlier version were brought over", patients)


def _take_over(storage: Storage) -> int:
    """The number of patients brought over, by this call or by one that was interrupted."""
    root = storage.root
    with closing(sqlite3.connect(f"{(root / OLD).absolute().as_uri()}?mode=rw", uri=True)) as old:
        old.row_factory = sqlite3.Row
        if not _rows(old, "sqlite_master", name="patients"):  # a server that was killed at its first start
            return 0
        for patient in _rows(old, "patients", order="position"):
            _bring_over(old, root, patient)
        storage.index.look()
        patients = {row["id"] for row in _rows(old, "patients") if _scans(old, row)}
        secrets = ("id", "token_sha256", "passcode_hash", "wrong_passcodes", "last_wrong_at", "forgiven_passcodes")
        with storage.index.writing() as rows:
            for link in _rows(old, "shares"):  # also of patients whom an interrupted call has brought over
                put_secret(rows, LinkSecret(*(link[name] for name in secrets)))
            for row in _rows(old, "ended_sessions"):
                end_session(rows, row["id_sha256"], row["ended_at"])
    missing = [each for each in patients if not (root / layout.CASES / each / layout.CASE).is_file()]
    if missing:
        raise BadSettings(f"{len(missing)} patients of an earlier version could not be brought over; see the log.")
    return len(patients)


def _scans(old: sqlite3.Connection, patient: sqlite3.Row) -> set[str]:
    """The patient's scans without those that are being deleted; a patient goes with the last."""
    removing = {row["scan"] for row in _rows(old, "file_journal") if row["removing"]}
    return {row["scan"] for row in _rows(old, "scans_of_patients", patient=patient["id"])} - removing


def _bring_over(old: sqlite3.Connection, root: Path, patient: sqlite3.Row) -> None:
    """Makes the patient's case, unless it is there, or has no scan.  Raises OSError, and then leaves nothing."""
    place, scans = root / layout.CASES / patient["id"], _scans(old, patient)
    if place.exists() or not scans:
        return
    with coming(root / layout.INCOMING) as made:
        _Case(old, root, patient, made).write(scans)
        for file in made.rglob("*"):
            if file.is_file() and file.stat().st_nlink == 1:  # what is linked is on the disk
                sync_file(file)
        os.rename(made, place)
    sync_folder(place.parent)


@dataclass(frozen=True)
class _Case:
    old: sqlite3.Connection
    root: Path
    patient: sqlite3.Row
    folder: Path

    def write(self, scans: Collection[str]) -> None:
        self._put(layout.CASE, CaseDocument(code=self.patient["code"], created_at=self.patient["created_at"]))
        self._put(LOCK, b"")
        for scan_id in sorted(scans):
            self._scan(scan_id)
        versions = _rows(self.old, "plans", order="version", patient=self.patient["id"])
        for number, row in enumerate(versions, start=1):
            plan = PlanDocument.model_validate(json.loads(row["json"]) | {"version": row["version"]})
            name = layout.PLAN if number == len(versions) else f"{layout.PLANS}/{row['version']:06}.json"
            self._put(name, plan)

    def _scan(self, scan_id: str) -> None:
        [row] = _rows(self.old, "scans", id=scan_id)
        part, file = layout.scan_part(scan_id), upload_name(row["file_type"])
        document = ScanDocument(
            created_at=row["created_at"], sha256=row["sha256"], facts=json.loads(row["facts"]), file=file
        )
        self._put(f"{part}/{layout.SCAN}", document)
        for name in (file, layout.MESH, layout.THUMBNAIL):
            self._link(scan_place(scan_id), name, f"{part}/{name}")
        for one in _rows(self.old, "landmarks", scan=scan_id):
            known = Picks(*(json.loads(one[name]) for name in ("points_mm", "certain", "confidence")))
            if known.points_mm:
                self._put(f"{part}/{layout.LANDMARKS}", landmark_document(known))
        for one in _rows(self.old, "cuts", scan=scan_id):
            self._put(f"{part}/{layout.CUTS}", CutsDocument(cuts=json.loads(one["json"])))
        for one in _rows(self.old, "ink", scan=scan_id):
            known_ink = json.loads(one["json"]) | {"dropped": json.loads(one["dropped"])}
            self._put(f"{part}/{layout.INK}", InkDocument.model_validate(known_ink))
        for one in _rows(self.old, "proposals", scan=scan_id):
            proposed = ProposalsDocument(key=one["model_sha256"], landmarks=json.loads(one["json"]))
            self._put(f"{part}/{layout.PROPOSALS}", proposed)
        for one in _rows(self.old, "expiring_scans", scan=scan_id):
            self._put(f"{part}/{layout.EXPIRES}", ExpiresDocument(announced_at=one["announced_at"]))
        for fit in _rows(self.old, "fits", order="place", scan=scan_id):
            self._fit(scan_id, fit)

    def _fit(self, scan_id: str, row: sqlite3.Row) -> None:
        part, place = layout.fit_part(scan_id, row["id"]), fit_place(row["id"])
        asked = {
            "asked_at": row["created_at"],
            "stance": row["asked_stance"] or row["stance"],
            "refine": bool(row["refine"]),
            **{name: json.loads(row[name]) for name in ("landmarks_mm", "certain", "confidence", "cuts")},
            **{name: row[name] for name in ("preset", "drawing", "start_from")},
        }
        for one in _rows(self.old, "asked_once", fit=row["id"]):
            asked |= {"key_sha256": one["key_sha256"], "request_sha256": one["request_sha256"]}
        self._put(f"{part}/{layout.FIT}", FitDocument.model_validate(asked))
        lines = [event["json"] for event in _rows(self.old, "events", order="number", fit=row["id"])]
        if lines:
            self._put(f"{part}/{layout.LOG}", ("\n".join(lines) + "\n").encode())
        folder = self.root / place
        for file in sorted(folder.iterdir()) if folder.is_dir() else ():
            if file.is_file() and file.name != layout.LOG:
                self._link(place, file.name, f"{part}/{file.name}")
        for link in _rows(self.old, "shares", order="position", fit=row["id"]):
            self._link_of_fit(layout.link_part(scan_id, row["id"], link["id"]), link)

    def _link_of_fit(self, part: str, row: sqlite3.Row) -> None:
        snapshot = str(row["snapshot"] or "")
        shown = self.root / share_place(snapshot) if snapshot else None
        number = 1 if shown is not None and shown.is_dir() else 0
        known = {name: row[name] for name in ("created_at", "expires_at", "revoked_at", "scan")}
        known |= {"notes": bool(row["notes"]), "shown": number, "shown_at": row["snapshot_at"]}
        self._put(f"{part}/{layout.LINK}", LinkDocument.model_validate(known))
        if number and shown is not None:
            for file in sorted(each for each in shown.rglob("*") if each.is_file()):
                inside = file.relative_to(shown).as_posix()
                self._link(share_place(snapshot), inside, f"{part}/{layout.SHOWN}1/{inside}")

    def _put(self, name: str, document: BaseModel | bytes) -> None:
        target = self.folder / name
        target.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        target.write_bytes(document if isinstance(document, bytes) else content_of(document))
        target.chmod(0o600)

    def _link(self, place: str, name: str, target: str) -> None:
        """Links a file that never changes."""
        source, goal = self.root / place / name, self.folder / target
        goal.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        try:
            os.link(source, goal)
        except FileNotFoundError:
            return
        except OSError:
            shutil.copyfile(source, goal)
            goal.chmod(0o600)
