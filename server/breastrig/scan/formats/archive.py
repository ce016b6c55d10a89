"""Reads zips of scanner apps: the one mesh with the material and pictures that it names, or the one label map.

Only these are unpacked, in memory. Meshes of one folder whose names differ in words such as "textured" or "refined" are
one scan, of which the one with a picture is read; any other choice is refused.
"""

import io
import re
import struct
import zipfile
import zlib
from collections import defaultdict
from dataclasses import dataclass
from functools import partial
from pathlib import PurePosixPath
from typing import IO

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.file_type import LOOKED_AT, plain_text, volume_kind
from breastrig.scan.limits import (
    FILE_BYTES,
    MATERIAL_FILE_BYTES,
    MEBIBYTE,
    ZIP_ENTRIES,
    ZIP_LIST_BYTES,
    ZIP_RATIO,
    ZIP_RATIO_FROM,
)
from breastrig.scan.pictures.companions import PICTURES, Companions
from breastrig.scan.point_clouds.point_table import is_point_table
from breastrig.scan.volumes.gzipped import GZIP_START, first_bytes, gunzipped

MODEL, ROOT_MODEL = "model", "3d/3dmodel.model"  # of a 3MF, which is a zip; others of its models are parts of that
# Of one scan in several formats the one that carries a picture is the best; a text is the scan if nothing else is.
MESH_RANK = {"txt": -1, "csv": -1, "xyz": 0, "pcd": 0, "stl": 1, "ply": 2, "obj": 2, "usdz": 3, "gltf": 4, "glb": 4}
MESH_RANK |= {"off": 1, "3mf": 2, MODEL: 2}
MESH_RANK |= {"asc": 0, "pts": 0, "xyzn": 0, "xyzrgb": 0, "usd": 3, "usda": 3, "usdc": 3}
LEFT_BY_MACOS = "__MACOSX"  # a folder added silently by the Finder; skipped unread
UTF_8_FLAG = 0x800
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # the others are unpacked without a limit by zipfile
LEADS_ELSEWHERE = re.compile(r"^/|^[A-Za-z]:|\\|(?:^|/)\.\.(?:/|$)")
WORD = re.compile(r"[^\W_]+")
# Words of file names that say what kind of file of one scan this is, not which scan: 3D Scanner App writes export.obj,
# export_refined.obj and textured_output.obj; Structure Model.obj; Polycam raw.glb; Revopoint _mesh, _pc and _tex.
PREVIEW = frozenset(("preview", "thumb", "thumbnail", "lowres", "lowpoly", "low"))
POINTS = frozenset(("pc", "pcd", "points", "pointcloud", "cloud"))
TEXTURED = frozenset(("textured", "texture", "tex"))
KINDS = (
    PREVIEW
    | POINTS
    | TEXTURED
    | frozenset(
        ("output", "export", "refined", "mesh", "model", "raw", "high", "hd", "simplified", "decimated", "poly", "scan")
    )
)
END, END_64 = b"PK\x05\x06", b"PK\x06\x07"
END_BYTES, END_64_BYTES, COMMENT_BYTES = 22, 20, 65_535
LIST_LENGTH_AT = 12  # bytes into the end record
UNREADABLE = (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError, ValueError)
VOLUMES = ("nii", "gz", "nrrd", "mha", "mhd", "dcm")
DAMAGED = "This zip file is cut off, damaged or encrypted; pack it again."
NO_MESH = (
    "This zip holds no mesh and no volume; pack exactly one OBJ, PLY, STL or GLB with its pictures, one label map "
    "(NIfTI, NRRD, MetaImage, DICOM SEG), or the DICOM files of an MRI."
)
SEVERAL_MAPS = (
    "This zip holds {count} label maps or volumes, and not one image among them; pack one image with its "
    "segmentations, or the label map that is meant alone."
)
SEVERAL_SCANS = "This zip holds {count} scans that have nothing to do with one another; pack one of them alone."
SAME_SCAN = "The zip holds this scan {count} times; the {kind} with the most on it was read."


@dataclass(frozen=True)
class Unpacked:
    """The unpacked contents of a zip."""

    mesh: bytes
    ending: str  # of the mesh's name, one of MESH_RANK
    companions: Companions
    notes: tuple[str, ...]


def unpacked(data: bytes) -> Unpacked:
    """The scan in a zip.  BadScan or TooLarge with a sentence."""
    try:
        check_list(io.BytesIO(data))
        return _taken(zipfile.ZipFile(io.BytesIO(data)))
    except UNREADABLE as error:
        raise BadScan(DAMAGED) from error


def check_list(archive: IO[bytes], most: int = ZIP_LIST_BYTES, files: int = ZIP_ENTRIES) -> None:
    """Checks the length of the list of entries, which is read whole before anything can be counted.

    BadScan or TooLarge with a sentence; OSError.
    """
    size = archive.seek(0, io.SEEK_END)
    archive.seek(max(0, size - END_64_BYTES - END_BYTES - COMMENT_BYTES))
    tail = archive.read()
    end = tail.rfind(END)
    if end < 0 or len(tail) < end + END_BYTES:
        raise BadScan(DAMAGED)
    (length,) = struct.unpack_from("<I", tail, end + LIST_LENGTH_AT)
    if tail[:end][-END_64_BYTES:].startswith(END_64) or length > most:
        raise TooLarge(f"This zip holds far more than the {files:,} files allowed, or is packed as if; pack it again.")


@dataclass(frozen=True)
class Entry:
    """A file of the zip."""

    info: zipfile.ZipInfo
    path: str
    folder: str  # lower case
    name: str  # lower case, without its folders
    ending: str

    @staticmethod
    def of(info: zipfile.ZipInfo) -> "Entry":
        path = PurePosixPath(_name(info).lower())
        return Entry(info, _name(info), str(path.parent), path.name, path.suffix.removeprefix("."))

    @property
    def words(self) -> frozenset[str]:
        """The words of its name, without the ending."""
        return frozenset(WORD.findall(PurePosixPath(self.name).stem))


def _name(info: zipfile.ZipInfo) -> str:
    """The entry's name. Many programs write UTF-8 without its flag; zipfile then assumes an old character set."""
    if info.flag_bits & UTF_8_FLAG:
        return info.filename
    try:
        return info.filename.encode("cp437").decode()
    except UnicodeError:
        return info.filename


def entries_of(archive: zipfile.ZipFile, most: int = ZIP_ENTRIES) -> list[Entry]:
    """The files that may be looked at.  BadScan or TooLarge with a sentence."""
    infos = archive.infolist()
    if len(infos) > most:
        raise TooLarge(f"This zip holds {len(infos):,} files, more than the {most:,} allowed.")
    if any(LEADS_ELSEWHERE.search(info.filename) for info in infos):
        raise BadScan("This zip holds names that lead out of it; pack it again.")
    entries = [Entry.of(info) for info in infos if not info.is_dir()]
    if len({(entry.folder, entry.name) for entry in entries}) != len(entries):
        raise BadScan("This zip holds two files of the same name; pack it again.")
    return [
        entry
        for entry in entries
        if LEFT_BY_MACOS.lower() not in PurePosixPath(entry.folder).parts and not entry.name.startswith(".")
    ]


class _Reader:
    """Unpacks single entries, together no more than one scan may have."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        self._left = FILE_BYTES

    def read(self, entry: Entry, most_packed: bool = True) -> bytes:
        info = entry.info
        if info.compress_type not in PACKINGS:
            raise BadScan("This zip is packed in an unusual way; pack it again as an ordinary zip.")
        if info.file_size > self._left:
            raise TooLarge(f"This zip unpacks to more than the {FILE_BYTES // MEBIBYTE} MB allowed.")
        if most_packed and info.file_size > max(ZIP_RATIO_FROM, ZIP_RATIO * info.compress_size):
            raise TooLarge(f"A file in this zip is packed more than {ZIP_RATIO} times; pack it with less compression.")
        self._left -= info.file_size
        try:
            return self._archive.read(info)
        except UNREADABLE as error:
            raise BadScan(DAMAGED) from error

    def start(self, entry: Entry) -> bytes:
        """The first bytes of the entry, unpacked if it is a .gz."""
        if entry.info.compress_type not in PACKINGS:
            return b""
        with self._archive.open(entry.info) as file:
            start = file.read(LOOKED_AT)
        return first_bytes(start) if start.startswith(GZIP_START) else start

    def volume(self, entry: Entry) -> bytes:
        """The label map's bytes, unpacked if it is a .gz; labels may be compressed more than other files."""
        content = self.read(entry, most_packed=False)
        return gunzipped(content) if content.startswith(GZIP_START) else content

    def companion(self, entry: Entry) -> bytes:
        """The file's bytes; of a material file only as many as show that it is over its limit."""
        content = self.read(entry)
        return content[: MATERIAL_FILE_BYTES + 1] if entry.ending == "mtl" else content


def _taken(archive: zipfile.ZipFile) -> Unpacked:
    entries = entries_of(archive)
    meshes = [entry for entry in entries if entry.ending in MESH_RANK]
    meshes = [entry for entry in meshes if entry.path.lower() == ROOT_MODEL] or [
        entry for entry in meshes if entry.ending != MODEL
    ]
    reader = _Reader(archive)
    volumes = [entry for entry in entries if entry.ending in VOLUMES]
    if not any(MESH_RANK[entry.ending] >= 0 for entry in meshes):
        if (volume := _volume(reader, entries)) is not None:
            return volume
    else:  # a text is the scan if nothing else is
        if volumes:
            raise BadScan("This zip holds a mesh and a volume; pack the one that is meant alone.")
        meshes = [entry for entry in meshes if MESH_RANK[entry.ending] >= 0]
    scans: dict[tuple[str, frozenset[str]], list[Entry]] = defaultdict(list)
    for entry in meshes:
        scans[entry.folder, entry.words - KINDS].append(entry)
    if len(scans) > 1:  # a preview beside the scan is no second scan
        scans = {which: found for which, found in scans.items() if any(not each.words & PREVIEW for each in found)}
    if len(scans) != 1:
        raise BadScan(SEVERAL_SCANS.format(count=len(scans)) if scans else NO_MESH)
    (found,) = scans.values()
    is_painted = any(entry.ending == "mtl" and entry.folder == found[0].folder for entry in entries) and any(
        entry.ending in PICTURES for entry in entries
    )
    mesh = max(found, key=lambda each: _preference(each, is_painted))
    found_beside = {_from(mesh.folder, entry): partial(reader.companion, entry) for entry in entries}
    notes = (SAME_SCAN.format(count=len(found), kind=mesh.ending.upper()),) if len(found) > 1 else ()
    content = reader.read(mesh)
    if MESH_RANK[mesh.ending] < 0 and not is_point_table(plain_text(content)[:LOOKED_AT]):
        raise BadScan(NO_MESH)
    return Unpacked(content, mesh.ending, Companions(lambda: found_beside), notes)


def _volume(reader: _Reader, entries: list[Entry]) -> Unpacked | None:
    """The one label map, by its bytes: on hospitals' media names say nothing.  BadScan where there are several."""
    kinds: dict[str, list[Entry]] = defaultdict(list)
    for entry in entries:
        kinds[volume_kind(reader.start(entry))].append(entry)
    maps = kinds["label map"]
    if len(maps) > 1:
        raise BadScan(SEVERAL_MAPS.format(count=len(maps)))
    chosen = next(iter([*maps, *kinds["structures"], *kinds["dicom"], *kinds["other"]]), None)
    if chosen is None:
        return None
    return Unpacked(reader.volume(chosen), chosen.ending, Companions(dict), ())


def _from(folder: str, entry: Entry) -> str:
    """The entry's path relative to this folder; paths outside it are put below a folder that no file names."""
    if folder == ".":
        return entry.path
    inside = entry.path[len(folder) + 1 :] if entry.path.lower().startswith(folder + "/") else ""
    return inside or f"beside/{entry.path}"


def _preference(mesh: Entry, is_painted: bool) -> tuple[bool, bool, bool, bool, int, int]:
    """Sort key among several meshes of one scan; the best is the highest."""
    words = mesh.words
    return (
        not words & PREVIEW,
        not words & POINTS,
        bool(words & TEXTURED),
        mesh.ending == "obj" and is_painted,
        MESH_RANK[mesh.ending],
        mesh.info.file_size,
    )
