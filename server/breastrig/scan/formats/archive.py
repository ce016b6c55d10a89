"""A zip as scanner apps send it: the one mesh that is meant, and the material and pictures that it names.

Apps pack more than the scan: folders, previews, every photograph with its camera, depth maps, descriptions in JSON, the
same body coarse, fine and with a picture.  What is not read is not unpacked either: the mesh first, then the materials
of its folder, then the pictures whose names stand in them.  Meshes of one folder whose names differ in words such as
"textured" or "refined" are one scan, and the one with a picture is read; between others nobody guesses.

Nothing is ever unpacked to the disk, so links, absolute names and the like in a zip lead nowhere.
"""

import io
import re
import struct
import zipfile
import zlib
from collections import defaultdict
from dataclasses import dataclass
from pathlib import PurePosixPath

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import (
    FILE_BYTES,
    MATERIAL_FILE_BYTES,
    MEBIBYTE,
    ZIP_ENTRIES,
    ZIP_LIST_BYTES,
    ZIP_RATIO,
    ZIP_RATIO_FROM,
)

MESHES = ("obj", "ply", "stl", "glb", "pcd", "xyz", "usdz")
# Of one scan in several formats the one that carries a picture is the best.
MESH_RANK = {"xyz": 0, "pcd": 0, "stl": 1, "ply": 2, "obj": 2, "usdz": 3, "glb": 4}
PICTURES = ("jpg", "jpeg", "png")
COMPANIONS = ("mtl", *PICTURES)
LEFT_BY_MACOS = "__MACOSX"  # a folder added silently by the Finder; skipped unread
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # the others are unpacked without a limit by zipfile
LEADS_ELSEWHERE = re.compile(r"^/|^[A-Za-z]:|\\|(?:^|/)\.\.(?:/|$)")
NAMES_A_PICTURE = re.compile(r"\.(?:jpe?g|png)\b", re.IGNORECASE)
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
DAMAGED = "This zip file is cut off, damaged or encrypted; pack it again."
SAME_SCAN = "The zip holds this scan {count} times; the {kind} with the most on it was read."


@dataclass(frozen=True)
class Unpacked:
    """What of a zip is read."""

    mesh: bytes
    ending: str  # of the mesh's name, one of MESHES
    companions: dict[str, bytes]  # by their plain names, which differ in more than case
    notes: tuple[str, ...]


def unpacked(data: bytes) -> Unpacked:
    """The scan in a zip.  BadScan or TooLarge with a sentence."""
    _check_list(data)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _taken(archive)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError, ValueError) as error:
        raise BadScan(DAMAGED) from error


def _check_list(data: bytes) -> None:
    """The list of entries is read whole before anything can be counted, so its length is looked at first."""
    tail = data[-END_64_BYTES - END_BYTES - COMMENT_BYTES :]
    end = tail.rfind(END)
    if end < 0 or len(tail) < end + END_BYTES:
        raise BadScan(DAMAGED)
    (length,) = struct.unpack_from("<I", tail, end + LIST_LENGTH_AT)
    if tail[:end][-END_64_BYTES:].startswith(END_64) or length > ZIP_LIST_BYTES:
        raise TooLarge(
            f"This zip holds far more than the {ZIP_ENTRIES:,} files allowed, or is packed as if; pack it again."
        )


@dataclass(frozen=True)
class _Entry:
    """A file of the zip."""

    info: zipfile.ZipInfo
    folder: str  # lower case
    name: str  # lower case, without its folders
    ending: str

    @staticmethod
    def of(info: zipfile.ZipInfo) -> "_Entry":
        path = PurePosixPath(info.filename.lower())
        return _Entry(info, str(path.parent), path.name, path.suffix.removeprefix("."))

    @property
    def words(self) -> frozenset[str]:
        """Of its name, without the ending."""
        return frozenset(WORD.findall(PurePosixPath(self.name).stem))


def _entries(archive: zipfile.ZipFile) -> list[_Entry]:
    """The files that may be looked at."""
    infos = archive.infolist()
    if len(infos) > ZIP_ENTRIES:
        raise TooLarge(f"This zip holds {len(infos):,} files, more than the {ZIP_ENTRIES:,} allowed.")
    if any(LEADS_ELSEWHERE.search(info.filename) for info in infos):
        raise BadScan("This zip holds names that lead out of it; pack it again.")
    entries = [_Entry.of(info) for info in infos if not info.is_dir()]
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
        self._read: dict[str, bytes] = {}

    def read(self, entry: _Entry) -> bytes:
        info = entry.info
        if info.filename in self._read:
            return self._read[info.filename]
        if info.compress_type not in PACKINGS:
            raise BadScan("This zip is packed in an unusual way; pack it again as an ordinary zip.")
        if info.file_size > self._left:
            raise TooLarge(f"This zip unpacks to more than the {FILE_BYTES // MEBIBYTE} MB allowed.")
        if info.file_size > max(ZIP_RATIO_FROM, ZIP_RATIO * info.compress_size):
            raise TooLarge(f"A file in this zip is packed more than {ZIP_RATIO} times; pack it with less compression.")
        self._left -= info.file_size
        self._read[info.filename] = self._archive.read(info)
        return self._read[info.filename]

    def materials(self, entries: list[_Entry], folder: str) -> dict[str, bytes]:
        """The MTL files beside a mesh; each that is far too long only by its first bytes and one, which is refused."""
        return {
            entry.name: self.read(entry)[: MATERIAL_FILE_BYTES + 1]
            for entry in entries
            if entry.ending == "mtl" and entry.folder == folder
        }


def _taken(archive: zipfile.ZipFile) -> Unpacked:
    entries = _entries(archive)
    scans: dict[tuple[str, frozenset[str]], list[_Entry]] = defaultdict(list)
    for entry in entries:
        if entry.ending in MESHES:
            scans[entry.folder, entry.words - KINDS].append(entry)
    if len(scans) > 1:  # a preview beside the scan is no second scan
        scans = {which: found for which, found in scans.items() if any(not each.words & PREVIEW for each in found)}
    if len(scans) != 1:
        raise BadScan(
            f"This zip holds {len(scans)} scans that have nothing to do with one another; pack one of them alone."
            if scans
            else "This zip holds no mesh; pack exactly one OBJ, PLY, STL or GLB with its pictures."
        )
    (found,) = scans.values()
    reader = _Reader(archive)
    pictures = [entry for entry in entries if entry.ending in PICTURES]
    material = reader.materials(entries, found[0].folder)
    mesh = max(found, key=lambda each: _preference(each, _named(pictures, material)))
    content = reader.read(mesh)
    naming = material if mesh.ending == "obj" else {"": content[:MATERIAL_FILE_BYTES]} if mesh.ending == "ply" else {}
    wanted = _nearest(_named(pictures, naming), mesh.folder)
    companions = {**material, **{entry.name: reader.read(entry) for entry in wanted}}
    notes = (SAME_SCAN.format(count=len(found), kind=mesh.ending.upper()),) if len(found) > 1 else ()
    return Unpacked(content, mesh.ending, companions, notes)


def _preference(mesh: _Entry, painted: list[_Entry]) -> tuple[bool, bool, bool, bool, int, int]:
    """The best of several meshes of one scan has the highest."""
    words = mesh.words
    return (
        not words & PREVIEW,
        not words & POINTS,
        bool(words & TEXTURED),
        mesh.ending == "obj" and bool(painted),
        MESH_RANK[mesh.ending],
        mesh.info.file_size,
    )


def _named(pictures: list[_Entry], texts: dict[str, bytes]) -> list[_Entry]:
    """The pictures whose names stand in one of the texts."""
    text = b"\n".join(texts.values())
    decoded = (text.decode("utf-8", "replace") + text.decode("latin-1")).lower()
    if not NAMES_A_PICTURE.search(decoded):
        return []
    return [entry for entry in pictures if entry.name in decoded]


def _nearest(pictures: list[_Entry], folder: str) -> list[_Entry]:
    """One of each name: that beside the mesh, else the least deep."""
    chosen: dict[str, _Entry] = {}
    for entry in sorted(pictures, key=lambda each: (each.folder != folder, each.folder.count("/"), each.folder)):
        chosen.setdefault(entry.name, entry)
    return list(chosen.values())
