"""The volumes' files of a folder or zip, known by their bytes, for on hospitals' media names say nothing."""

import hashlib
import os
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from io import BytesIO
from pathlib import Path

from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.private_files import read_ordinary
from breastrig.scan.file_type import LOOKED_AT, is_dicom, volume_kind
from breastrig.scan.formats.archive import (
    DAMAGED,
    MESH_RANK,
    PACKINGS,
    UNREADABLE,
    check_list,
    entries_of,
)
from breastrig.scan.limits import (
    IMAGE_BYTES,
    IMAGE_FILE_BYTES,
    IMAGE_FILES,
    IMAGE_FOLDERS,
    IMAGE_ZIP_BYTES,
    IMAGE_ZIP_LIST_BYTES,
    MEBIBYTE,
    ZIP_RATIO,
    ZIP_RATIO_FROM,
)
from breastrig.scan.volumes.gzipped import GZIP_START, first_bytes

ZIP_START = b"PK\x03\x04"
ALONE = "give the series that is meant alone"
TOO_MANY = f"More than the {IMAGE_FILES:,} files allowed are there; {ALONE}."
TOO_LONG = f"A DICOM file has more than the {IMAGE_FILE_BYTES // MEBIBYTE} MB allowed; export the series alone."


@dataclass(frozen=True, eq=False)
class DicomFile:
    """A file whose first bytes are those of DICOM, or of a volume of another format."""

    size: int  # bytes, as its folder or zip says
    read: Callable[[int], bytes]  # at most so many of its first bytes; BadScan where it is damaged
    is_grid: bool = False  # NIfTI, NRRD or MetaImage, perhaps packed as .gz

    def whole(self) -> bytes:
        """All of its bytes.  BadScan, TooLarge."""
        if self.size > IMAGE_FILE_BYTES:
            raise TooLarge(TOO_LONG)
        return self.read(self.size)


def one_file(data: bytes) -> DicomFile:
    return DicomFile(len(data), lambda count: data[:count])


@contextmanager
def dicom_files(source: Path | bytes) -> Iterator[list[DicomFile]]:
    """The DICOM files and other volumes of a folder or of a zip that holds no mesh; none of every other file.

    They can be read while the context lasts.  Raises BadScan or TooLarge.
    """
    if isinstance(source, Path) and source.is_dir():
        yield _bounded(_in_folder(source))
        return
    if not may_hold_dicom(source):
        yield []
        return
    if (size := len(source) if isinstance(source, bytes) else source.stat().st_size) > IMAGE_ZIP_BYTES:
        limit = IMAGE_ZIP_BYTES // MEBIBYTE
        raise TooLarge(f"This zip has {size // MEBIBYTE:,} MB, more than the {limit:,} MB allowed.")
    try:
        with BytesIO(source) if isinstance(source, bytes) else source.open("rb") as stream:
            check_list(stream, IMAGE_ZIP_LIST_BYTES, IMAGE_FILES)
            with zipfile.ZipFile(stream) as archive:
                yield _bounded(_in_zip(archive))
    except UNREADABLE as error:
        raise BadScan(DAMAGED) from error


def zip_of_folder(folder: Path, most: int) -> bytes:
    """The folder's DICOM files as a zip that is the same for the same contents.

    BadScan where it cannot be read, TooLarge for more than so many bytes.
    """
    files = _in_folder(folder)
    if sum(file.size for file in files) > most:
        raise TooLarge(f"The DICOM files of this folder have more than the {most // MEBIBYTE:,} MB allowed.")
    stream = BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for at, file in enumerate(files):
            archive.writestr(zipfile.ZipInfo(f"{at:05d}.dcm"), file.whole())
    return stream.getvalue()


def sha256_of(source: Path | bytes) -> str:
    """Of a file's bytes; of a folder, of those of all its DICOM files whatever they are called.

    BadScan where it cannot be read; OSError.
    """
    if isinstance(source, bytes):
        return hashlib.sha256(source).hexdigest()
    if source.is_dir():
        parts = sorted(hashlib.sha256(file.whole()).digest() for file in _in_folder(source))
        return hashlib.sha256(b"".join(parts)).hexdigest()
    with source.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def may_hold_dicom(source: Path | bytes) -> bool:
    """Whether it is a folder or a zip."""
    if isinstance(source, bytes):
        return source.startswith(ZIP_START)
    with suppress(OSError, ValueError):
        return source.is_dir() or read_ordinary(source, len(ZIP_START) - 1) == ZIP_START
    return False


def _in_folder(folder: Path) -> list[DicomFile]:
    """The ordinary files in it and in its folders; links are left out."""
    found: list[tuple[str, DicomFile]] = []
    folders, seen = [folder], 0
    for here in folders:
        try:
            with os.scandir(here) as entries:
                for entry in entries:
                    seen += 1
                    if seen > 2 * IMAGE_FILES or len(folders) > IMAGE_FOLDERS:
                        raise TooLarge(TOO_MANY)
                    if entry.name.startswith("."):
                        continue
                    if entry.is_dir(follow_symlinks=False):
                        folders.append(Path(entry.path))
                    elif entry.is_file(follow_symlinks=False):
                        file = DicomFile(entry.stat(follow_symlinks=False).st_size, partial(_start, Path(entry.path)))
                        found += [(entry.path, each) for each in _volume(file)]
        except OSError as error:
            raise BadScan(f"This folder cannot be read ({error.strerror}); check who may read it.") from error
    if len(found) > IMAGE_FILES:
        raise TooLarge(TOO_MANY)
    return [file for _, file in sorted(found, key=lambda each: each[0])]


def _volume(file: DicomFile) -> tuple[DicomFile, ...]:
    """The file with what it holds, if that is a volume."""
    start = file.read(LOOKED_AT)
    if is_dicom(start):
        return (file,)
    start = first_bytes(start) if start.startswith(GZIP_START) else start
    is_grid = volume_kind(start) == "label map" and not is_dicom(start)
    return (replace(file, is_grid=True),) if is_grid else ()


def _start(file: Path, count: int) -> bytes:
    try:
        return read_ordinary(file, count)[:count]
    except OSError as error:
        raise BadScan(f"A file of this folder cannot be read ({error.strerror}); check who may read it.") from error


def _bounded(files: list[DicomFile]) -> list[DicomFile]:
    if sum(file.size for file in files) > IMAGE_BYTES:
        raise TooLarge(f"The DICOM files there have more than the {IMAGE_BYTES // MEBIBYTE:,} MB allowed; {ALONE}.")
    return files


def _in_zip(archive: zipfile.ZipFile) -> list[DicomFile]:
    if len(archive.infolist()) > 2 * IMAGE_FILES:
        raise TooLarge(TOO_MANY)
    entries = entries_of(archive, 2 * IMAGE_FILES)
    if any(MESH_RANK.get(entry.ending, -1) >= 0 for entry in entries):
        return []
    found = []
    for info in (entry.info for entry in entries if entry.info.compress_type in PACKINGS):
        for file in _volume(DicomFile(info.file_size, partial(_unpacked, archive, info))):
            if not file.is_grid and info.file_size > max(ZIP_RATIO_FROM, ZIP_RATIO * info.compress_size):
                raise TooLarge(
                    f"A file in this zip is packed more than {ZIP_RATIO} times; pack it with less compression."
                )
            found.append(file)
    if len(found) > IMAGE_FILES:
        raise TooLarge(TOO_MANY)
    return found


def _unpacked(archive: zipfile.ZipFile, info: zipfile.ZipInfo, count: int) -> bytes:
    try:
        with archive.open(info) as stream:
            return stream.read(count)
    except UNREADABLE as error:
        raise BadScan(DAMAGED) from error
