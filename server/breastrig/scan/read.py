"""A scan file -> Scan.  The only way in for untrusted bytes.

The kind of file is decided from its bytes, limits are checked on the file's own numbers before anything of that size
is allocated, no other file or address is ever opened, and whatever goes wrong inside a library becomes one plain
sentence.  What comes out is checked again, whatever file it came in.
"""

import hashlib
import stat
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.single_precision import EXACT_WITHIN
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.clean import MIN_TRIANGLES
from breastrig.scan.file_type import file_type_of
from breastrig.scan.formats.archive import COMPANIONS, unpacked
from breastrig.scan.formats.glb import glb_pieces
from breastrig.scan.formats.texture import written_anew
from breastrig.scan.formats.usd_process import usd_pieces
from breastrig.scan.joined_textures import UNPAINTED, joined_textures
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE, TRIANGLES
from breastrig.scan.piece import Piece, Pieces, PointCloud
from breastrig.scan.point_clouds.pcd import pcd_points
from breastrig.scan.point_clouds.point_text import text_points
from breastrig.scan.scan import Scan
from breastrig.scan.stored_scan import STORED, read_stored
from breastrig.scan.units import decide_unit, extent

BEYOND = 1e30  # no unit has such numbers; their squares are beyond single precision
FARTHEST = 1e7  # m from the origin; coordinates of the Earth reach 6.4e6 m, and double precision is 2e-9 m there
STRAY = 1e3  # m from the scan's middle; no scanner sees so far, and single precision begins to matter
SHOWN_NAME = 60  # characters of a file's name in a sentence


def read_scan(
    source: Path | bytes,
    file_type: str | None = None,
    units: str = "auto",
    texture: bool = True,
    for_display: bool = True,
) -> Scan:
    """Reads PLY, OBJ, STL, GLB, PCD, rows of points, or a zip of one of them with its MTL and pictures.

    `file_type` is the name's ending, only used to word errors, or STORED for a file that `write_stored` wrote;
    `units` is auto or m, dm, cm, mm, in, ft; `texture=False` saves the time of decoding the pictures,
    `for_display=False` that of writing a smaller one to be shown: whoever decodes it then sees whether it is sound.
    Raises BadScan, TooLarge (over a limit) or BadSettings (no such unit), each with one sentence.
    """
    if file_type == STORED and isinstance(source, Path):
        scan = read_stored(source, texture, for_display)
        unit, reason = decide_unit(_extent(scan.vertices, scan.faces) / scan.metres_per_unit, units)
        metres = METRES_PER_UNIT[unit]
        vertices = scan.vertices if unit == scan.unit else scan.vertices * (metres / scan.metres_per_unit)
        return replace(scan, vertices=vertices, unit=unit, metres_per_unit=metres, unit_reason=reason)
    data = _bytes(source)
    siblings: Mapping[str, bytes] = {}
    sorting: tuple[str, ...] = ()
    if file_type is None and isinstance(source, Path):
        file_type = source.suffix
    found = file_type_of(data, file_type)
    mesh = data
    if found == "zip":
        packed = unpacked(data)
        mesh, siblings, sorting = packed.mesh, packed.companions, packed.notes
        found = file_type_of(mesh, packed.ending)
        if found == "zip":
            raise BadScan("This zip holds another zip; pack the mesh itself.")
    elif found in ("obj", "ply") and isinstance(source, Path) and texture:
        siblings = _Siblings(source.parent)
    if found == "glb":
        pieces = glb_pieces(mesh, texture)
    elif found == "usd":
        pieces = usd_pieces(mesh, texture)
    elif found in ("pcd", "xyz"):
        pieces = Pieces((), has_points=True, cloud=pcd_points(mesh) if found == "pcd" else text_points(mesh))
    else:
        from breastrig.scan.formats.ply_obj_stl import mesh_pieces  # its parsers take 0.4 s to load

        pieces = mesh_pieces(mesh, found, siblings if texture else {}, texture)
    from_points = pieces.cloud is not None and not pieces.pieces
    if from_points and pieces.cloud is not None:
        cloud = _sound_points(pieces.cloud)
        unit, reason = decide_unit(extent(cloud.points), units)
        from breastrig.scan.point_clouds.surface_from_points import (  # few scans are points
            FROM_POINTS,
            surface_from_points,
        )

        whole, notes = surface_from_points(cloud, METRES_PER_UNIT[unit]), (FROM_POINTS, *pieces.notes)
        _check(whole, pieces.has_points)
    else:
        whole, notes = _joined(pieces)
        _check(whole, pieces.has_points)
        unit, reason = decide_unit(_extent(whole.vertices, whole.faces), units)
    metres = METRES_PER_UNIT[unit]
    whole, strays = _placed(whole, metres)
    jpeg = whole.picture if whole.picture is None or not for_display else written_anew(whole.picture)
    if whole.picture is not None and jpeg is None:
        notes += ("The texture is damaged and was left out.",)
    return Scan(
        vertices=whole.vertices * metres,
        faces=whole.faces,
        unit=unit,
        metres_per_unit=metres,
        unit_reason=reason,
        sha256=hashlib.sha256(data).hexdigest(),
        notes=(*sorting, *notes, *strays, *_far_away(whole.vertices, metres)),
        colours=whole.colours if jpeg is None else None,
        uv=None if jpeg is None else whole.uv,
        texture=jpeg,
        picture=None if jpeg is None else whole.picture,
        from_points=from_points,
    )


class _Siblings(Mapping[str, bytes]):
    """Materials and pictures in the folder of a file, read when asked for, never outside that folder."""

    def __init__(self, folder: Path) -> None:
        self._paths = {
            path.name: path
            for path in folder.iterdir()
            if path.suffix.lower().lstrip(".") in COMPANIONS and path.is_file() and not path.is_symlink()
        }

    def __getitem__(self, name: str) -> bytes:
        return _bytes(self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


def _bytes(source: Path | bytes) -> bytes:
    if isinstance(source, bytes):
        _check_size(len(source))
        return source
    shown = source.name if len(source.name) <= SHOWN_NAME else f"{source.name[:SHOWN_NAME]}..."
    try:
        facts = source.stat()
        if not stat.S_ISREG(facts.st_mode):
            raise BadScan(f"What is called {shown} is no ordinary file; give a scan file.")
        _check_size(facts.st_size)
        return source.read_bytes()
    except (OSError, ValueError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or "no such name is possible"
        raise BadScan(f"The file {shown} cannot be read ({reason}); check the name.") from error


def _check_size(size: int) -> None:
    if size > FILE_BYTES:
        raise TooLarge(f"This file has {size // MEBIBYTE:,} MB, more than the {FILE_BYTES // MEBIBYTE} MB allowed.")


def _joined(found: Pieces) -> tuple[Piece, tuple[str, ...]]:
    """All pieces as one, with the colours or the picture that they share, and what there is to say."""
    pieces = found.pieces
    if not pieces:
        return Piece(np.zeros((0, 3)), np.zeros((0, 3), np.int64)), found.notes
    offsets = np.cumsum([0, *(len(piece.vertices) for piece in pieces[:-1])])
    vertices = np.concatenate([piece.vertices for piece in pieces])
    faces = np.concatenate([piece.faces + offset for piece, offset in zip(pieces, offsets, strict=True)])
    notes, colours, uv, picture = found.notes, None, None, None
    painted = [piece for piece in pieces if piece.uv is not None and piece.picture is not None]
    if painted:
        first = painted[0].picture
        if len(painted) < len(pieces) or any(piece.picture != first for piece in painted):
            picture, uv, why = joined_textures(pieces)
            notes += () if why is None else (why,)
            notes += (UNPAINTED,) if why is None and len(painted) < len(pieces) else ()
        elif np.isfinite(uv := np.concatenate([piece.uv for piece in painted if piece.uv is not None])).all():
            picture = first
    coloured = [piece.colours for piece in pieces if piece.colours is not None]
    if len(coloured) == len(pieces):
        colours = np.concatenate(coloured)
    return Piece(vertices, faces, colours, None if picture is None else uv, picture), notes


def _sound_points(cloud: PointCloud) -> PointCloud:
    """The points that are places; BadScan when there are next to none."""
    sound = (np.abs(cloud.points) < BEYOND).all(axis=1)  # false for what is no number, too
    if int(sound.sum()) < MIN_TRIANGLES:
        raise BadScan(f"This scan has only {int(sound.sum())} points and no triangles; export it as a triangle mesh.")
    return PointCloud(
        cloud.points[sound],
        None if cloud.normals is None else np.nan_to_num(cloud.normals[sound], posinf=0.0, neginf=0.0),
        None if cloud.colours is None else cloud.colours[sound],
        cloud.sensor,
    )


def _check(whole: Piece, has_points: bool) -> None:
    """What every scan must be, whatever file it came in."""
    if not len(whole.faces):
        what = "only points" if has_points else "no triangles"
        raise BadScan(f"This scan has {what}; export it as a triangle mesh.")
    if whole.faces.min() < 0 or whole.faces.max() >= len(whole.vertices):
        raise BadScan("The triangles of this scan name vertices that do not exist; export it again.")
    sound = (np.abs(whole.vertices) < BEYOND).all(axis=1)  # false for what is no number, too
    if not sound.all():
        bad = int((~sound).sum())
        which = "One vertex of this scan is" if bad == 1 else f"{bad:,} vertices of this scan are"
        raise BadScan(f"{which} not finite or far beyond all reason; repair the mesh or export it again.")
    if len(whole.faces) > TRIANGLES:
        raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")
    if len(whole.faces) < MIN_TRIANGLES:
        count = "1 triangle" if len(whole.faces) == 1 else f"{len(whole.faces)} triangles"
        raise BadScan(f"This scan has only {count}, too few to show a torso; export the whole mesh.")


def _extent(vertices: Array, faces: Integers) -> float:
    """How far the triangles reach, in the vertices' unit."""
    used = np.zeros(len(vertices), np.bool_)
    used[faces[:, 0]] = True
    return extent(vertices[used])


def _placed(whole: Piece, metres: float) -> tuple[Piece, tuple[str, ...]]:
    """The scan without unused points far away, and a note of them; BadScan when a triangle lies out of all reach."""
    used = np.zeros(len(whole.vertices), np.bool_)
    used[whole.faces] = True
    middle = np.median(whole.vertices[used], axis=0)
    if metres * float(np.abs(middle).max()) > FARTHEST:
        raise BadScan(
            f"This scan lies {metres * float(np.linalg.norm(middle)):.3g} m from the origin of its coordinates, "
            "where numbers are too coarse for it; move it to the origin before it is exported."
        )
    astray: Booleans = np.any(metres * np.abs(whole.vertices - middle) > STRAY, axis=1)
    if not astray.any():
        return whole, ()
    if (astray & used).any():
        count = int((astray & used).sum())
        which = "One vertex of this scan lies" if count == 1 else f"{count:,} vertices of this scan lie"
        raise BadScan(f"{which} more than {STRAY / 1e3:g} km from the rest; repair the mesh or export it again.")
    number = np.cumsum(used) - 1
    kept = replace(
        whole,
        vertices=whole.vertices[used],
        faces=number[whole.faces],
        colours=None if whole.colours is None else whole.colours[used],
        uv=None if whole.uv is None else whole.uv[used],
    )
    return kept, ("Points far away that no triangle uses were left out.",)


def _far_away(vertices: Array, metres: float) -> tuple[str, ...]:
    """What a place far from the origin does to numbers in single precision: the file's own, or those for display."""
    reach = float(np.abs(vertices).max())
    if metres * reach <= EXACT_WITHIN:
        return ()
    where = f"The scan lies {metres * reach:,.0f} m from the origin of its coordinates"
    if np.array_equal(vertices, vertices.astype(np.float32)):
        step = 1e3 * metres * float(np.spacing(np.float32(reach)))
        return (f"{where}, and its file rounds them to {step:.2g} mm; move it to the origin before it is exported.",)
    step = 1e3 * float(np.spacing(np.float32(metres * reach)))
    return (f"{where}; results are exact there, but pictures of it may be rounded to {step:.2g} mm.",)
