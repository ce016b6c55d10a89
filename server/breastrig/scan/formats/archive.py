"""A zip with one mesh and its material and pictures, as scanner apps send it; nothing else is let through.

Nothing is ever unpacked to the disk, so links, absolute names and the like in a zip lead nowhere.
"""

import io
import struct
import zipfile
import zlib

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE, ZIP_ENTRIES, ZIP_LIST_BYTES, ZIP_RATIO, ZIP_RATIO_FROM

MESHES = ("obj", "ply", "stl", "glb")
COMPANIONS = ("mtl", "jpg", "jpeg", "png")
LEFT_BY_MACOS = ("__MACOSX/", ".DS_Store")  # added silently by the Finder; skipped unread
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # the others are unpacked without a limit by zipfile
END, END_64 = b"PK\x05\x06", b"PK\x06\x07"
END_BYTES, END_64_BYTES, COMMENT_BYTES = 22, 20, 65_535
LIST_LENGTH_AT = 12  # bytes into the end record
DAMAGED = "This zip file is cut off, damaged or encrypted; pack it again."


def unpacked(data: bytes) -> tuple[str, dict[str, bytes]]:
    """(name of the mesh file, all files by name).  BadScan or TooLarge with a sentence."""
    _check_list(data)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = [entry for entry in archive.infolist() if not entry.filename.startswith(LEFT_BY_MACOS)]
            _check(entries)
            files = {entry.filename: archive.read(entry) for entry in entries}
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError, ValueError) as error:
        raise BadScan(DAMAGED) from error
    meshes = [name for name in files if _ending(name) in MESHES]
    if len(meshes) != 1:
        raise BadScan(f"This zip holds {len(meshes)} meshes; pack exactly one OBJ, PLY, STL or GLB with its pictures.")
    return meshes[0], files


def _check_list(data: bytes) -> None:
    """The list of entries is read whole before anything can be counted, so its length is looked at first."""
    tail = data[-END_64_BYTES - END_BYTES - COMMENT_BYTES :]
    end = tail.rfind(END)
    if end < 0 or len(tail) < end + END_BYTES:
        raise BadScan(DAMAGED)
    (length,) = struct.unpack_from("<I", tail, end + LIST_LENGTH_AT)
    if tail[:end][-END_64_BYTES:].startswith(END_64) or length > ZIP_LIST_BYTES:
        raise TooLarge(
            f"This zip holds far more than the {ZIP_ENTRIES} files allowed, or is packed as if; pack it again."
        )


def _check(entries: list[zipfile.ZipInfo]) -> None:
    if len(entries) > ZIP_ENTRIES:
        raise TooLarge(f"This zip holds {len(entries)} files, more than the {ZIP_ENTRIES} allowed.")
    if sum(entry.file_size for entry in entries) > FILE_BYTES:
        raise TooLarge(f"This zip unpacks to more than the {FILE_BYTES // MEBIBYTE} MB allowed.")
    for entry in entries:
        if entry.is_dir() or set(entry.filename) & set("/\\:") or entry.filename.startswith("."):
            raise BadScan("This zip holds folders; pack the mesh, its MTL and its pictures without folders.")
        if _ending(entry.filename) not in (*MESHES, *COMPANIONS):
            raise BadScan("This zip holds a file that is no OBJ, MTL, JPEG, PNG, PLY, STL or GLB; leave it out.")
        if entry.compress_type not in PACKINGS:
            raise BadScan("This zip is packed in an unusual way; pack it again as an ordinary zip.")
        if entry.file_size > max(ZIP_RATIO_FROM, ZIP_RATIO * entry.compress_size):
            raise TooLarge(f"A file in this zip is packed more than {ZIP_RATIO} times; pack it with less compression.")
    names = [entry.filename.lower() for entry in entries]
    if len(set(names)) != len(names):
        raise BadScan("This zip holds two files of the same name; pack it again.")


def _ending(name: str) -> str:
    return name.rsplit(".", 1)[-1].lower() if "." in name else ""
