"""A zip with one mesh and its material and pictures, as scanner apps send it; nothing else is let through."""

import io
import zipfile
import zlib

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE, ZIP_ENTRIES, ZIP_RATIO, ZIP_RATIO_FROM

MESHES = ("obj", "ply", "stl", "glb")
COMPANIONS = ("mtl", "jpg", "jpeg", "png")
LEFT_BY_MACOS = ("__MACOSX/", ".DS_Store")  # added silently by the Finder; skipped unread


def unpacked(data: bytes) -> tuple[str, dict[str, bytes]]:
    """(name of the mesh file, all files by name).  BadScan or TooLarge with a sentence."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = [entry for entry in archive.infolist() if not entry.filename.startswith(LEFT_BY_MACOS)]
            _check(entries)
            files = {entry.filename: archive.read(entry) for entry in entries}
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError, ValueError) as error:
        raise BadScan("This zip file is cut off, damaged or encrypted; pack it again.") from error
    meshes = [name for name in files if _ending(name) in MESHES]
    if len(meshes) != 1:
        raise BadScan(f"This zip holds {len(meshes)} meshes; pack exactly one OBJ, PLY, STL or GLB with its pictures.")
    return meshes[0], files


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
        if entry.file_size > max(ZIP_RATIO_FROM, ZIP_RATIO * entry.compress_size):
            raise TooLarge(f"A file in this zip is packed more than {ZIP_RATIO} times; pack it with less compression.")
    names = [entry.filename.lower() for entry in entries]
    if len(set(names)) != len(names):
        raise BadScan("This zip holds two files of the same name; pack it again.")


def _ending(name: str) -> str:
    return name.rsplit(".", 1)[-1].lower() if "." in name else ""
