"""Makes a backup of a data folder, also of one that a server serves.

A tar in an age file: `installation`, `cases/`, `models/`, `audit/`, and last `manifest.json`, which says what of all
this counts.  Each case is linked aside under its lock, so that nobody waits for the disk of the backup.  At the end
cases that were written meanwhile are put in again, until in one look none has changed: so a scan that moves is in one
case.
"""

import hashlib
import io
import json
import os
import tarfile
from contextlib import suppress
from pathlib import Path

from breastrig.audit.log import END, FOLDER, AuditLog, Entry, log_files
from breastrig.backup.age import SealedWriter
from breastrig.backup.restore import MANIFEST, SCHEMA, Restored, restore
from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder, coming, utc_now
from breastrig.cases.removal import finish
from breastrig.cases.writing import LOCK, PART, locked, stamp_of, sync_folder
from breastrig.core.errors import BadInput, Conflict, NotFound
from breastrig.core.private_files import shown
from breastrig.storage.files import MODELS

LOOKS = 100
LEFT_OUT = (LOCK, layout.CLAIM)
READ = 2**20
RESTLESS = "Cases are written faster than they can be copied; make the backup at a quieter time."


def back_up(data: Path, target: Path, passphrase: str, who: str) -> Restored:
    """Makes the backup and restores it for a trial before it gets its name; what the trial has found.

    Raises BadInput, Conflict while cases do not rest, OSError.
    """
    if os.path.lexists(target):
        raise BadInput(f"{shown(target)} is there already; name a new file.")
    if data.resolve() in target.resolve().parents:
        raise BadInput("A backup inside the data folder is lost with it; name a place outside, best on another disk.")
    AuditLog(data).append(Entry(who, "export", "backup"))
    part = target.with_name(f".{target.name}.part")
    try:
        with part.open("wb") as file:
            os.chmod(part, 0o600)
            sealed = SealedWriter(file, passphrase)
            packed = _Packed(data, sealed)
            packed.pack()
            sealed.close()
            file.flush()
            os.fsync(file.fileno())
        with coming(data / layout.INCOMING) as trial:
            found = restore(part, trial / "data", passphrase, who)
        os.replace(part, target)
        sync_folder(target.absolute().parent)
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
    return found


class _Packed:
    """The tar as it is being written."""

    def __init__(self, data: Path, sealed: SealedWriter) -> None:
        self._data = data
        self._tar = tarfile.open(fileobj=sealed, mode="w|", bufsize=READ)  # type: ignore[call-overload]  # noqa: SIM115
        self._files: dict[str, tuple[int, str]] = {}  # {name: (size, SHA-256)}

    def pack(self) -> None:
        self._add_file(self._data / layout.MARK, layout.MARK)
        taken: dict[str, int] = {}
        for _ in range(LOOKS):
            now = self._stamps()
            for gone in taken.keys() - now.keys():
                self._forget(gone)
                del taken[gone]
            changed = [case_id for case_id, stamp in now.items() if taken.get(case_id) != stamp]
            if not changed:
                break
            for case_id in changed:
                self._forget(case_id)
                taken.pop(case_id, None)
                with suppress(NotFound):
                    taken[case_id] = self._add_case(self._data / layout.CASES / case_id)
        else:
            raise Conflict(RESTLESS)
        models = self._data / MODELS
        for file in sorted(models.iterdir()) if models.is_dir() else ():
            self._add_file(file, f"{MODELS}/{file.name}")
        self._add_file(self._data / FOLDER / END, f"{FOLDER}/{END}")  # first: lines that come meanwhile are beyond it
        for file in log_files(self._data / FOLDER):
            content = file.read_bytes()
            self._add(f"{FOLDER}/{file.name}", content[: content.rfind(b"\n") + 1])
        manifest = {"schema": SCHEMA, "made_at": utc_now(), "cases": sorted(taken), "files": self._files}
        self._add(MANIFEST, json.dumps(manifest).encode())
        self._tar.close()

    def _stamps(self) -> dict[str, int]:
        found = {}
        for name in os.listdir(self._data / layout.CASES):
            with suppress(FileNotFoundError):
                if layout.ID.fullmatch(name) and (self._data / layout.CASES / name / layout.CASE).is_file():
                    found[name] = stamp_of(self._data / layout.CASES / name)
        return found

    def _forget(self, case_id: str) -> None:
        place = f"{layout.CASES}/{case_id}/"
        self._files = {name: known for name, known in self._files.items() if not name.startswith(place)}

    def _add_case(self, path: Path) -> int:
        """Its stamp. Raises NotFound when it is gone."""
        case = CaseFolder(path)
        finish(case)  # a deletion or move that was interrupted
        with coming(self._data / layout.INCOMING) as aside:
            with locked(path):
                case.document()
                stamp = stamp_of(path)
                deleted = {scan for scan, is_deleted in case.around.marks().items() if is_deleted}
                names = [name for name in _files_of(path) if not deleted & set(name.split("/"))]
                for name in names:
                    (aside / name).parent.mkdir(parents=True, exist_ok=True)
                    with suppress(FileNotFoundError):  # a worker's, which holds its fit alone
                        os.link(path / name, aside / name)
            for name in names:
                with suppress(FileNotFoundError):
                    self._add_file(aside / name, f"{layout.CASES}/{path.name}/{name}")
        return stamp

    def _add_file(self, path: Path, name: str) -> None:
        """As long as it is now: a log may grow meanwhile."""
        with path.open("rb") as file:
            size, digest = os.fstat(file.fileno()).st_size, hashlib.sha256()
            self._tar.addfile(_entry(name, size), _Hashed(file, digest))
        self._files[name] = size, digest.hexdigest()

    def _add(self, name: str, content: bytes) -> None:
        self._tar.addfile(_entry(name, len(content)), io.BytesIO(content))
        self._files[name] = len(content), hashlib.sha256(content).hexdigest()


class _Hashed:
    def __init__(self, file: io.BufferedReader, digest: "hashlib._Hash") -> None:
        self._file, self._digest = file, digest

    def read(self, size: int) -> bytes:
        content = self._file.read(size)
        self._digest.update(content)
        return content


def _entry(name: str, size: int) -> tarfile.TarInfo:
    entry = tarfile.TarInfo(name)
    entry.size, entry.mode = size, 0o600
    return entry


def _files_of(folder: Path) -> list[str]:
    """All files of a case but for locks and what killed writers have left."""
    found = []
    for place, folders, names in os.walk(folder):
        folders.sort()
        kept = [name for name in sorted(names) if name not in LEFT_OUT and not name.startswith(PART)]
        found += [os.path.relpath(os.path.join(place, name), folder) for name in kept]
    return found
