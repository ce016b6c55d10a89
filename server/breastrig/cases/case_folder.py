"""One case: opens and creates it, adds scans and reads them."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel

from breastrig.cases import layout
from breastrig.cases.documents import CaseDocument, ScanDocument, content_of, read_document
from breastrig.cases.layout import Surroundings, data_folder_of, new_id, scan_part, surroundings_of
from breastrig.cases.writing import LOCK, NONE_HERE, put, stamp_of, sync_folder, writing
from breastrig.core import wall_clock
from breastrig.core.errors import BadInput, NeedsYes, NotFound
from breastrig.core.identity import CODE_CHARACTERS, one_line, random_code
from breastrig.core.private_files import private_folder, shown
from breastrig.core.scratch import locked_folder, remove_abandoned
from breastrig.scan.true_size import facts_in, kept_size

COMING = ".coming-"  # folders of what comes in; those of killed programs are removed
NO_SCAN = "There is no such scan; it may have been deleted."

Read = TypeVar("Read", bound=BaseModel)


@dataclass(frozen=True)
class ScanEntry:
    """One scan of a case."""

    id: str
    document: ScanDocument


@dataclass(frozen=True)
class MadeScan(ScanEntry):
    """A scan that is to be added to a case."""

    folder: Path  # its files, on the disk of the case


class CaseFolder:
    """An existing case. May be used from any thread and process; its content is not cached."""

    def __init__(self, path: Path) -> None:
        """Opens the case. Raises NotFound when there is none."""
        self.path = path.absolute()
        if not (self.path / layout.CASE).is_file():
            raise NotFound(f"There is no case at {shown(path)}; name a folder that holds {layout.CASE}.")

    @staticmethod
    def create(path: Path, code: str = "") -> "CaseFolder":
        """A new case without scans under that code, a random one where it is empty.

        Raises BadInput where something is already, or nothing can be written.
        """
        chosen = checked_code(code) or random_code()
        try:
            with new_case(path, chosen):
                pass
        except OSError as error:
            if os.path.lexists(path):
                raise BadInput(f"{shown(path)} is there already; name a new folder for the case.") from error
            raise BadInput(f"{shown(path)} cannot be written ({error.strerror}); choose another place.") from error
        return CaseFolder(path)

    @staticmethod
    def of_scan(path: Path, code: str, first: MadeScan, group: str | None = None) -> "CaseFolder":
        """A new case with its first scan, put in place together.  Raises OSError."""
        _complete(first)
        with new_case(path, code, group) as folder:
            (folder / layout.SCANS).mkdir(mode=0o700)
            os.rename(first.folder, folder / scan_part(first.id))
            sync_folder(folder / layout.SCANS)
        return CaseFolder(path)

    @property
    def id(self) -> str:
        return self.path.name

    @cached_property
    def around(self) -> Surroundings:
        return surroundings_of(self.path)

    @property
    def stamp(self) -> int:
        """The case's stamp: another number after each change. Raises NotFound."""
        try:
            return stamp_of(self.path)
        except FileNotFoundError as error:
            raise NotFound(NONE_HERE) from error

    def writing(self) -> AbstractContextManager[None]:
        """Holds the case for changes inside the block.  Raises NotFound when it is gone, Conflict when it is busy."""
        return writing(self.path)

    def document(self) -> CaseDocument:
        """The case's document. Raises NotFound when the case is gone, BadInput when the file is damaged."""
        found = self.read(layout.CASE, CaseDocument)
        if found is None:
            raise NotFound(NONE_HERE)
        return found

    def rename(self, code: str) -> CaseDocument:
        """Gives the patient another code, a new random one where it is empty.  Raises NotFound, BadInput."""
        chosen = checked_code(code) or random_code()
        with self.writing():
            document = self.document().model_copy(update={"code": chosen})
            put(self.path, layout.CASE, content_of(document))
        return document

    def give_to(self, group: str | None) -> None:
        """The patient is owned by that group of people from then on, by None of them for None.  Raises NotFound."""
        with self.writing():
            put(self.path, layout.CASE, content_of(self.document().model_copy(update={"group": group})))

    def content(self, name: str) -> bytes | None:
        """A file of the case by its name inside it; None where there is none."""
        try:
            return (self.path / name).read_bytes()
        except (FileNotFoundError, NotADirectoryError):
            return None

    def read(self, name: str, kind: type[Read]) -> Read | None:
        """A document of the case; None where there is none.  Raises BadInput when it is damaged."""
        content = self.content(name)
        return None if content is None else read_document(kind, content, name)

    def scan_ids(self) -> set[str]:
        """The ids of the case's scans."""
        try:
            names = {name for name in os.listdir(self.path / layout.SCANS) if layout.ID.fullmatch(name)}
        except FileNotFoundError:
            return set()
        return names - self._deleted() if names else names

    def _deleted(self) -> set[str]:
        """Scans that are deleted, though their folder may still be in its place."""
        return {scan for scan, deleted in self.around.marks().items() if deleted}

    def scans(self) -> list[ScanEntry]:
        """The scans, oldest first. Raises BadInput for a damaged one."""
        found = [ScanEntry(each, document) for each in self.scan_ids() if (document := self._scan(each)) is not None]
        return sorted(found, key=lambda one: (one.document.created_at, one.id))

    def scan(self, scan_id: str) -> ScanDocument:
        """The scan's entry. Raises NotFound."""
        self.check_scan(scan_id)
        found = self._scan(scan_id)
        if found is None:
            raise NotFound(NO_SCAN)
        return found

    def _scan(self, scan_id: str) -> ScanDocument | None:
        """In the scan's true size."""
        found = self.read(f"{scan_part(scan_id)}/{layout.SCAN}", ScanDocument)
        size = None if found is None else kept_size(self.scan_folder(scan_id))
        if found is None or size is None:
            return found
        return found.model_copy(update={"facts": facts_in(found.facts, size)})

    def scan_folder(self, scan_id: str) -> Path:
        return self.path / scan_part(scan_id)

    def check_scan(self, scan_id: str) -> None:
        """Raises NotFound when the scan is not here: under `writing`, that stays so."""
        folder = self.scan_folder(scan_id)
        if not folder.is_dir() or scan_id in self._deleted():
            raise NotFound(NO_SCAN)

    @contextmanager
    def incoming(self) -> Iterator[Path]:
        """A private folder for what is to become part of the case; what is left in it goes at the end of the block."""
        with coming(self.around.incoming) as folder:
            yield folder

    def add_scan(self, made: Path, document: ScanDocument, scan_id: str = "", again: bool = False) -> str:
        """Puts a scan's folder, made in `incoming`, into the case, whole; its id.

        Raises NotFound when the case is gone, NeedsYes where it has a scan of the same file and nobody said `again`.
        """
        scan_id = scan_id or new_id()
        _complete(MadeScan(scan_id, document, made))
        with self.writing():
            if not again and any(one.document.sha256 == document.sha256 for one in self.scans()):
                raise NeedsYes("This scan is already here: the same file is one of this patient's scans", "again")
            self.put_folder(made, scan_part(scan_id))
        return scan_id

    def put_folder(self, made: Path, part: str) -> None:
        """Renames a folder that was made in `incoming` to its place inside the case; under `writing`."""
        target = self.path / part
        private_folder(target.parent)
        os.rename(made, target)
        sync_folder(target.parent)


@contextmanager
def new_case(path: Path, code: str, group: str | None = None) -> Iterator[Path]:
    """A folder that is the case of that place at the end of the block, with what was put into it.  Raises OSError."""
    path = path.absolute()
    root = data_folder_of(path)
    private_folder(path.parent)
    with coming(path.parent if root is None else root / layout.INCOMING) as folder:
        put(folder, layout.CASE, content_of(CaseDocument(code=code, created_at=utc_now(), group=group)))
        put(folder, LOCK, b"")
        yield folder
        os.rename(folder, path)
    sync_folder(path.parent)


def _complete(made: MadeScan) -> None:
    """Writes the document of a new scan, and syncs all its files to the disk."""
    put(made.folder, layout.SCAN, content_of(made.document))
    for file in made.folder.iterdir():
        file.chmod(0o600)
        sync_file(file)


@contextmanager
def coming(parent: Path) -> Iterator[Path]:
    """A folder that is renamed to its place inside the block, or removed."""
    private_folder(parent)
    remove_abandoned(parent, COMING)
    with locked_folder(parent, COMING) as holder:
        made = Path(tempfile.mkdtemp(dir=holder))
        yield made


def sync_file(file: Path) -> None:
    """Syncs the file's content to the disk."""
    descriptor = os.open(file, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def remove_tree(path: Path) -> None:
    """Removes as much as possible, never the target of a link. Raises OSError when something is left."""
    if path.is_symlink() or not path.is_dir():
        path.unlink(missing_ok=True)
        return
    shutil.rmtree(path, ignore_errors=True)
    if os.path.lexists(path):
        with suppress(FileNotFoundError):
            shutil.rmtree(path)  # once more, to hear what is in the way


def checked_code(code: str) -> str:
    """The code as stored. Raises BadInput."""
    found = one_line(code)
    if len(found) > CODE_CHARACTERS:
        raise BadInput(f"A patient's code has at most {CODE_CHARACTERS} characters; shorten it.")
    return found


def utc_now() -> str:
    """ISO 8601 in UTC, to the millisecond; sorts as text in the order of time."""
    return wall_clock.now().isoformat(timespec="milliseconds").replace("+00:00", "Z")
