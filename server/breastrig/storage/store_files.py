"""Files in any store that fsspec knows, such as S3.

Whatever is read is fetched into a scratch folder first, and whatever is kept is written there first, because the
programs that read and write scans need files of their own.  Nothing that was fetched outlives its use, and no list
of the store's content is kept, so that a deleted scan is gone.

The store's credentials come from its own settings (for S3 the environment or ~/.aws), never from ours.
"""

import errno
import hashlib
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from breastrig.core.errors import BadSettings
from breastrig.core.scratch import scratch_folder
from breastrig.storage.data_folder import PLACES
from breastrig.storage.files import MARK, OpenedFile

PROBE = ".writable"  # written and removed again at each start
BLOCK_BYTES = 2**20  # fetched ahead while a file is answered


@dataclass(frozen=True)
class ScratchDraft:
    """A scratch folder, whose files go into the store at once when they are whole."""

    folder: Path
    put: Callable[[], None]
    remove: Callable[[], None]

    def keep(self) -> None:
        self.put()

    def take_back(self) -> None:
        self.remove()


class StoreFiles:
    """The Files below a URL.  Raises BadSettings when fsspec, or what it needs for this URL, is not installed."""

    def __init__(self, url: str) -> None:
        self._url = url
        try:
            from fsspec.core import url_to_fs  # only large installations have it
        except ImportError as error:
            raise BadSettings("A store of files needs fsspec; install it with: pip install 'breastrig[s3]'.") from error
        try:
            fs, root = url_to_fs(url, use_listings_cache=False, skip_instance_cache=True)
        except (ImportError, ValueError) as error:
            raise BadSettings(
                f"Files cannot be kept at {url} ({error}); check the URL, for S3: pip install 'breastrig[s3]'."
            ) from error
        if hasattr(fs, "auto_mkdir"):  # a folder; stores have none, and would be made to make a bucket
            fs.auto_mkdir = True
        self._fs: Any = fs
        self._root = root.rstrip("/")

    def create(self) -> None:
        try:
            if self._is_of_others():
                raise BadSettings(
                    f"{self._url} holds files but no mark of BreastRig, so it is left as it is; choose an empty place "
                    "with --files."
                )
            probe = self._path(PROBE)
            self._fs.pipe_file(probe, b"")
            self._fs.rm_file(probe)
        except BadSettings:
            raise
        except Exception as error:  # each kind of store has errors of its own
            said = str(error).strip().splitlines()[0].rstrip(".") if str(error).strip() else type(error).__name__
            raise BadSettings(
                f"The files at {self._url} cannot be reached ({said}); check the URL, the store and its credentials."
            ) from error

    def make(self, place: str) -> None:
        pass

    @contextmanager
    def reading(self, place: str, names: Collection[str] | None = None) -> Iterator[Path]:
        with scratch_folder() as folder:
            self._fetch(place, names, folder)
            yield folder

    @contextmanager
    def writing(self, place: str) -> Iterator[ScratchDraft]:
        with scratch_folder() as folder:
            yield ScratchDraft(folder, lambda: self._put(place, folder), lambda: self.remove(place))

    def find(self, place: str, name: str) -> OpenedFile | None:
        path = self._path(place, name)
        with _as_os_errors():
            try:
                facts = self._fs.info(path)
            except FileNotFoundError:
                return None
        changed = facts.get("ETag") or facts.get("mtime") or facts.get("created")
        etag = hashlib.sha256(f"{changed} {facts['size']}".encode()).hexdigest()[:32]
        return OpenedFile(None, int(facts["size"]), etag, lambda: self._open(path))

    def write(self, place: str, name: str, content: bytes) -> None:
        with _as_os_errors():
            self._fs.pipe_file(self._path(place, name), content)

    def is_empty(self) -> bool:
        return not any(self._names(kind) for kind in PLACES)

    def remove(self, place: str) -> None:
        with _as_os_errors(), suppress(FileNotFoundError):
            self._fs.rm(self._path(place), recursive=True)

    def left_of(self, place: str) -> str:
        return f"{self._url}/{place}"

    def count_unknown(self, known: Collection[str]) -> int:
        return len({f"{kind}/{name}" for kind in PLACES for name in self._names(kind)} - set(known))

    def _is_of_others(self) -> bool:
        """Whether there is something, but not our mark.  Raises what the store raises."""
        try:
            found = self._fs.ls(self._root, detail=False, refresh=True)
        except FileNotFoundError:
            return False
        paths = {path.rstrip("/") for path in found} - {self._root, self._path(PROBE)}
        return bool(paths) and self._path(MARK) not in paths

    def _fetch(self, place: str, names: Collection[str] | None, folder: Path) -> None:
        with _as_os_errors():
            found = self._fs.find(self._path(place)) if names is None else [self._path(place, name) for name in names]
            for path in found:
                with suppress(FileNotFoundError):
                    self._fs.get_file(path, str(folder / path.rpartition("/")[2]))

    def _put(self, place: str, folder: Path) -> None:
        with _as_os_errors():
            for file in sorted(folder.iterdir()):
                self._fs.put_file(str(file), self._path(place, file.name))

    def _open(self, path: str) -> IO[bytes]:
        with _as_os_errors():
            opened: IO[bytes] = self._fs.open(path, "rb", block_size=BLOCK_BYTES)
        return opened

    def _names(self, kind: str) -> set[str]:
        with _as_os_errors():
            try:
                found = self._fs.ls(f"{self._root}/{kind}", detail=False, refresh=True)
            except FileNotFoundError:  # S3 knows no empty folders
                return set()
        return {path.rstrip("/").rpartition("/")[2] for path in found} - {kind, ""}

    def _path(self, *parts: str) -> str:
        return "/".join((self._root, *(part for part in parts if part)))


@contextmanager
def _as_os_errors() -> Iterator[None]:
    """Only the log distinguishes a store that does not answer from a disk that does not."""
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        raise OSError(errno.EIO, f"the store of files does not answer ({type(error).__name__})") from error
