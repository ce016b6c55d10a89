"""Restores a backup into a new data folder: whole or not at all, each file compared with its hash.

All is put into `.restoring` first; the marker `installation`, without which no server takes the folder, comes last.
Patients whose deletion is in a newer audit log are left out.  There is no index, so links come back closed.
"""

import hashlib
import json
import os
import shutil
import tarfile
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from breastrig.audit.log import FOLDER, AuditLog, Entry, Mark, installation_of
from breastrig.audit.read import check, deletions
from breastrig.backup.age import DAMAGED, SealedReader
from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder, remove_tree
from breastrig.cases.removal import delete_case, delete_scan
from breastrig.core.errors import BadInput, NotFound
from breastrig.core.private_files import private_folder, shown
from breastrig.storage.data_folder import OF_A_FILE_SYSTEM, write_marker
from breastrig.storage.files import MODELS

MANIFEST, SCHEMA = "manifest.json", "breastrig/backup@1"
RESTORING = ".restoring"  # in the folder until all is there
PLACES = (layout.CASES, MODELS, FOLDER)
READ = 2**20
OTHER_LOG = "The given audit log is not that of the backup, or is older than the backup; give the newest one."


@dataclass(frozen=True)
class Restored:
    """What was restored."""

    made_at: str  # ISO 8601, UTC: when the backup was made
    cases: int
    files: int
    deleted: tuple[str, ...]  # ids of patients and scans in the backup that were deleted since, as far as is known


def restore(
    file: Path, data: Path, passphrase: str, who: str, log: Path | None = None, with_deleted: bool = False
) -> Restored:
    """`log`: a newer audit log, as a data folder or a file of lines.  Raises BadInput with one sentence, OSError."""
    _check_target(data)
    private_folder(data)
    part = data / RESTORING
    for name in (RESTORING, *PLACES):  # of a restoring that was interrupted
        remove_tree(data / name)
    part.mkdir(mode=0o700)
    try:
        with file.open("rb") as sealed:
            manifest = _extracted(sealed, part, passphrase)
        checked = check(part)
        if checked.fault:
            raise BadInput(f"The audit log in the backup is not as it was written: {checked.fault}")
        if log is not None:
            _take_log(log, part, checked.end)
        deleted = _deleted_since(part, checked.end.line) if log is not None else []
        for case_id, scan in () if with_deleted else deleted:
            case = CaseFolder(part / layout.CASES / case_id)
            if delete_scan(case, scan) if scan else delete_case(case):
                raise BadInput(f"The deleted patient {case_id} cannot be left out; look what is in the way in {part}.")
        ids = tuple(scan or case_id for case_id, scan in deleted)
        said = {"made_at": manifest["made_at"], "deleted" if with_deleted else "left_out": len(ids)}
        AuditLog(part).append(Entry(who, "change", "restore", more=said))
        for name in PLACES:
            if (part / name).is_dir():
                os.rename(part / name, data / name)
        if hasattr(os, "sync"):
            os.sync()
        write_marker(data, installation_of(part))
    except BaseException:
        remove_tree(part)
        raise
    remove_tree(part)
    cases = sum(layout.ID.fullmatch(name) is not None for name in os.listdir(data / layout.CASES))
    return Restored(manifest["made_at"], cases, len(manifest["files"]), ids)


def _check_target(data: Path) -> None:
    names = set(os.listdir(data)) - OF_A_FILE_SYSTEM if data.is_dir() else set()
    if (names and RESTORING not in names) or layout.MARK in names or (os.path.lexists(data) and not data.is_dir()):
        raise BadInput(f"{shown(data)} is in use; a backup is restored into a new or empty folder.")


def _extracted(sealed: IO[bytes], part: Path, passphrase: str) -> dict[str, Any]:
    """Puts the files of the backup in place; its manifest. Raises BadInput."""
    known: dict[str, tuple[int, str]] = {}
    reader = SealedReader(sealed, passphrase)
    manifest: dict[str, Any] = {}
    try:
        with tarfile.open(fileobj=reader, mode="r|", bufsize=READ) as tar:  # type: ignore[call-overload]
            for entry in tar:
                content = tar.extractfile(entry)
                if content is None or not _is_ours(entry.name):
                    raise BadInput("The backup holds what BreastRig has not put there; it is not restored.")
                if entry.name == MANIFEST:
                    manifest = json.loads(content.read())
                else:
                    known[entry.name] = _written(content, part / entry.name)
        while reader.read(READ):  # to the last chunk, whose mark says that nothing is missing
            pass
        if manifest["schema"] != SCHEMA:
            raise BadInput("The backup is of another version of BreastRig; restore it with that one.")
        wanted = {name: (size, sha256) for name, (size, sha256) in manifest["files"].items()}
    except (tarfile.TarError, ValueError, KeyError, TypeError) as error:
        raise BadInput(DAMAGED) from error
    if any(known.get(name) != facts for name, facts in wanted.items()) or layout.MARK not in wanted:
        raise BadInput(DAMAGED)
    for name in known.keys() - wanted.keys():  # of cases that were written, moved or deleted meanwhile
        (part / name).unlink()
    for place, _, _ in os.walk(part, topdown=False):  # a scan without files would be one
        if not os.listdir(place):
            os.rmdir(place)
    (part / layout.CASES).mkdir(mode=0o700, exist_ok=True)
    return manifest


def _is_ours(name: str) -> bool:
    parts = name.split("/")
    return name in (layout.MARK, MANIFEST) or (
        parts[0] in PLACES and len(parts) > 1 and not {"", ".", ".."} & set(parts) and "\0" not in name
    )


def _written(content: IO[bytes], file: Path) -> tuple[int, str]:
    private_folder(file.parent)
    size, digest = 0, hashlib.sha256()
    with open(file, "wb", opener=lambda path, flags: os.open(path, flags, 0o600)) as written:
        while piece := content.read(READ):
            written.write(piece)
            digest.update(piece)
            size += len(piece)
    return size, digest.hexdigest()


def _take_log(log: Path, part: Path, end: Mark) -> None:
    """Puts a newer audit log in the place of the backup's. Raises BadInput where it does not go on from that one."""
    remove_tree(part / FOLDER)
    if log.is_dir():
        shutil.copytree(log / FOLDER if (log / FOLDER).is_dir() else log, part / FOLDER)
    elif log.is_file():
        (part / FOLDER).mkdir(mode=0o700)
        shutil.copyfile(log, part / FOLDER / "0000000001.jsonl")
    else:
        raise BadInput(f"There is no audit log at {shown(log)}; name a data folder, or a file of its lines.")
    found = check(part, end)
    if found.fault:
        raise BadInput(f"{OTHER_LOG} {found.fault}")


def _deleted_since(part: Path, after: int) -> list[tuple[str, str]]:
    """(case, scan, or "" for the whole case) of what is in the backup and was deleted after its last line."""
    found = []
    for line in deletions(part):
        if line["n"] > after:
            case_id, whole = line["of"]["patient"], line["removes"]["case"]
            scan = "" if whole else line["of"].get("scan", "")
            try:
                scans = CaseFolder(part / layout.CASES / case_id).scan_ids()
            except NotFound:
                continue
            if (whole or scan in scans) and (case_id, scan) not in found:
                found.append((case_id, scan))
    return sorted(found, key=lambda one: one[1] == "")  # scans first: a case goes with its last
