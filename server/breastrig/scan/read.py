"""A scan file -> Scan.  The only way in for untrusted bytes.

The kind of file is decided from its bytes, limits are checked on the file's own numbers before anything of that size
is allocated, no other file or address is ever opened, and whatever goes wrong inside a library becomes one plain
sentence.  What comes out is checked again, whatever file it came in.
"""

import hashlib
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan, BadSettings, TooLarge
from breastrig.core.single_precision import EXACT_WITHIN
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.clean import MIN_TRIANGLES
from breastrig.scan.file_type import VOLUMES, file_type_of, plain_text
from breastrig.scan.images.dicom_files import may_hold_dicom, sha256_of
from breastrig.scan.limits import NO_PLACES, TOO_MANY_TRIANGLES, TRIANGLES
from breastrig.scan.pictures.companions import Companions, beside
from breastrig.scan.pictures.joined_textures import UNPAINTED, joined_textures
from breastrig.scan.pictures.texture import written_anew
from breastrig.scan.piece import PARTLY_COLOURED, UNCOLOURED, BallInside, Piece, Pieces, PointCloud, SeenLandmark, part
from breastrig.scan.scan import Scan
from breastrig.scan.stored_scan import STORED, read_stored
from breastrig.scan.units import decide_unit, extent
from breastrig.scan.unscaled import NO_SCALE, comments, names_unscaled
from breastrig.scan.untrusted import bytes_of, guarded
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers
from breastrig.scan.volumes.gzipped import GZIP_START, gunzipped

PICTURE_TOO_LARGE = "The picture of this scan is over a limit and was left out; scale it down to have its colours."
UNPAINTED_ARRAYS = (
    "The triangles were given without colours, so areolae, navel and pen lines are not looked for; "
    "give colours, or the scan's file."
)
BEYOND = 1e30  # no unit has such numbers; their squares are beyond single precision
BROKEN = 0.05  # share of the triangles that may have such corners
FARTHEST = 1e7  # m from the origin; coordinates of the Earth reach 6.4e6 m, and double precision is 2e-9 m there
STRAY = 1e3  # m from the scan's middle; no scanner sees so far, and single precision begins to matter


def read_scan(
    source: Path | bytes,
    file_type: str | None = None,
    units: str = "auto",
    texture: bool = True,
    for_display: bool = True,
    answers: VolumeAnswers = NOTHING_SAID,
) -> Scan:
    """Reads PLY, OBJ, STL, GLB, glTF, USD, OFF, 3MF, PCD, a table of points, a label map (NIfTI, NRRD, MetaImage,
    DICOM SEG), a zip of one of them with what it names, or an MRI (DICOM): a folder, a zip, or one file of all slices.

    `file_type` is the name's ending, only used to word errors, or STORED for a file that `write_stored` wrote;
    `units` is auto or m, dm, cm, mm, in, ft; `texture=False` saves the time of decoding the pictures,
    `for_display=False` that of writing a smaller one to be shown: whoever decodes it then sees whether it is sound.
    `answers` is what a person says of a label map or of an MRI.
    Raises BadScan, TooLarge (over a limit) or BadSettings (no such unit, answers that do not fit), each with one
    sentence; of BadScan NeedsAnswer, where a person has to say something.
    """
    if file_type == STORED and isinstance(source, Path):
        scan = read_stored(source, texture, for_display)
        unit, reason = decide_unit(_extent(scan.vertices, scan.faces) / scan.metres_per_unit, units)
        metres = METRES_PER_UNIT[unit]
        vertices = scan.vertices if unit == scan.unit else scan.vertices * (metres / scan.metres_per_unit)
        return replace(scan, vertices=vertices, unit=unit, metres_per_unit=metres, unit_reason=reason)
    image = _image_in(source, units, answers)
    if isinstance(image, Pieces):
        return _of_pieces(image, sha256_of(source), units, for_display)
    data = image if isinstance(image, bytes) else bytes_of(source)
    if file_type is None and isinstance(source, Path):
        file_type = source.suffix
    unpacked_data = gunzipped(data) if data.startswith(GZIP_START) else data
    mesh, files, sorting = plain_text(unpacked_data), Companions(), tuple[str, ...]()
    found = file_type_of(mesh, file_type)
    if found == "zip":
        from breastrig.scan.formats.archive import unpacked

        packed = unpacked(unpacked_data)
        packed = unpacked(packed.mesh) if packed.ending == "3mf" else packed  # which is a zip itself
        mesh, files, sorting = plain_text(packed.mesh), packed.companions, packed.notes
        found = file_type_of(mesh, packed.ending)
        if found == "zip":
            raise BadScan("This zip holds another zip; pack the mesh itself.")
    elif isinstance(source, Path) and found in ("obj", "ply", "gltf", "glb"):
        files = beside(source, bytes_of)
    is_volume = found in VOLUMES
    if answers and not is_volume:
        raise BadSettings("This scan is no label map and no MRI; frame, segments and series are for those alone.")
    kept = (units, answers) if is_volume else (files, texture)
    pieces = guarded(found, partial(_volume if is_volume else _pieces, mesh, found, *kept))
    if names_unscaled(comments(mesh, found)):
        pieces = replace(pieces, is_unscaled=True)
    return _of_pieces(pieces, hashlib.sha256(data).hexdigest(), units, for_display, sorting)


def _of_pieces(pieces: Pieces, sha256: str, units: str, for_display: bool, sorting: tuple[str, ...] = ()) -> Scan:
    """The scan of a file's contents, checked; `sorting` is what its zip has to say."""
    from_points = pieces.cloud is not None and not pieces.pieces
    if from_points and pieces.cloud is not None:
        cloud = _sound_points(pieces.cloud)
        unit, reason = _unit(pieces, extent(cloud.points), units)
        from breastrig.scan.point_clouds.surface_from_points import (  # few scans are points
            FROM_POINTS,
            surface_from_points,
        )

        whole, notes = surface_from_points(cloud, METRES_PER_UNIT[unit]), (FROM_POINTS, *pieces.notes)
        _check(whole, pieces.has_points)
    else:
        whole, notes = _joined(pieces)
        whole, left_out = _without_bad_vertices(whole)
        notes += left_out
        _check(whole, pieces.has_points)
        across = _extent(whole.vertices, whole.faces)
        what = "A label map" if pieces.is_label_map else "An MRI" if pieces.image is not None else ""
        unit, reason = (
            ("mm", f"{what} has a unit of its own; what it shows is {1e-3 * across:.3g} m across.")
            if what
            else _unit(pieces, across, units)
        )
    notes = (*sorting, *notes)
    scan = _scan(whole, unit, reason, sha256, notes, for_display, from_points)
    metres = scan.metres_per_unit
    inside = tuple(BallInside(each.name, metres * each.center, metres * each.radius) for each in pieces.lesions)
    return replace(
        scan,
        from_label_map=pieces.is_label_map,
        from_image=pieces.image is not None,
        image=pieces.image,
        size_known=not (pieces.is_unscaled or (pieces.unit_by_default and units == "auto")),
        lesions=inside,
        seen=tuple(SeenLandmark(each.name, metres * each.place, metres * each.radius) for each in pieces.seen),
        segments=pieces.segments,
        stated_stance=pieces.stance,
        wall=None if pieces.wall is None else (metres * pieces.wall[0], pieces.wall[1]),
    )


def _unit(pieces: Pieces, across: float, units: str) -> tuple[str, str]:
    """As `decide_unit`."""
    try:
        return decide_unit(across, units, pieces.unit, pieces.unit_by_default)
    except BadScan as error:
        if not pieces.is_unscaled:
            raise
        raise BadScan(f"{error} {NO_SCALE}") from error


def _image_in(source: Path | bytes, units: str, answers: VolumeAnswers) -> Pieces | bytes | None:
    """The MRI that a folder or zip holds; the bytes of a folder's one label map; None for every other file."""
    if not may_hold_dicom(source):
        return None
    from breastrig.scan.images.read_volumes import pieces_in

    return guarded("dicom", partial(pieces_in, source, units, answers))


def coloured_scan(
    source: Path | bytes, file_type: str | None, units: str, answers: VolumeAnswers = NOTHING_SAID
) -> Scan:
    """The scan as `read_scan` returns it; without its picture and with a note where only that is over a limit."""
    try:
        return read_scan(source, file_type, units, for_display=False, answers=answers)
    except TooLarge:
        found = read_scan(source, file_type, units, texture=False, answers=answers)
        return replace(found, notes=(*found.notes, PICTURE_TOO_LARGE))


def scan_of_arrays(vertices: Array, faces: Integers, colours: NDArray[np.uint8] | None, units: str) -> Scan:
    """The scan of (V, 3) vertices in this unit and (F, 3) triangles, colours (V, 3) sRGB; checked as a file's."""
    joined, notes = _joined(Pieces((Piece(vertices, faces, colours),)))
    whole, left_out = _without_bad_vertices(joined)
    _check(whole, has_points=False)
    unit, reason = decide_unit(_extent(whole.vertices, whole.faces), units)
    plain = () if colours is not None else (UNPAINTED_ARRAYS,)
    content = hashlib.sha256(vertices.tobytes() + faces.tobytes() + (b"" if colours is None else colours.tobytes()))
    return _scan(whole, unit, reason, content.hexdigest(), (*notes, *left_out, *plain))


def _scan(
    whole: Piece,
    unit: str,
    reason: str,
    sha256: str,
    notes: tuple[str, ...],
    for_display: bool = False,
    from_points: bool = False,
) -> Scan:
    """The scan in metres."""
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
        sha256=sha256,
        notes=(*notes, *strays, *_far_away(whole.vertices, metres)),
        colours=whole.colours if jpeg is None else None,
        uv=None if jpeg is None else whole.uv,
        texture=jpeg,
        picture=None if jpeg is None else whole.picture,
        from_points=from_points,
    )


def _pieces(data: bytes, kind: str, files: Companions, texture: bool) -> Pieces:
    """The contents of a file of this kind, by the one reader that it needs."""
    if kind in ("glb", "gltf"):
        from breastrig.scan.formats.gltf.glb import glb_pieces

        return glb_pieces(data, files, texture)
    if kind == "usd":
        from breastrig.scan.formats.usd_process import usd_pieces

        return usd_pieces(data, texture)
    if kind == "pcd":
        from breastrig.scan.point_clouds.pcd import pcd_points

        return Pieces((), has_points=True, cloud=pcd_points(data))
    if kind == "xyz":
        from breastrig.scan.point_clouds.point_table import table_points

        return Pieces((), has_points=True, cloud=table_points(data))
    if kind == "stl":
        from breastrig.scan.formats.stl import read_stl

        return read_stl(data)
    if kind == "off":
        from breastrig.scan.formats.off import read_off

        return read_off(data)
    if kind == "3mf":
        from breastrig.scan.formats.threemf import read_3mf

        return read_3mf(data, files, texture)
    if kind == "obj":
        from breastrig.scan.formats.obj import read_obj

        return read_obj(data, files, texture)
    from breastrig.scan.formats.ply import read_ply

    return read_ply(data, files, texture)


def _volume(data: bytes, kind: str, units: str, answers: VolumeAnswers) -> Pieces:
    from breastrig.scan.images.read_volumes import pieces_of  # few scans are volumes

    return pieces_of(data, kind, units, answers)


def _joined(found: Pieces) -> tuple[Piece, tuple[str, ...]]:
    """All pieces as one, with their common colours or picture, and notes."""
    for piece in found.pieces:
        if len(piece.faces) and not 0 <= piece.faces.min() <= piece.faces.max() < len(piece.vertices):
            raise BadScan("The triangles of this scan name vertices that do not exist; export it again.")
    pieces = [each for piece in found.pieces for each in _placed_or_not(piece)]
    if not pieces:
        return Piece(np.zeros((0, 3)), np.zeros((0, 3), np.int64)), found.notes
    offsets = np.cumsum([0, *(len(piece.vertices) for piece in pieces[:-1])])
    vertices = np.concatenate([piece.vertices for piece in pieces])
    faces = np.concatenate([piece.faces + offset for piece, offset in zip(pieces, offsets, strict=True)])
    notes, uv, picture = found.notes, None, None
    painted = [piece for piece in pieces if piece.picture is not None]
    if painted:
        first = painted[0].picture
        if len(painted) < len(pieces) or any(piece.picture != first for piece in painted):
            picture, uv, why = joined_textures(pieces)
            notes += () if why is None else (why,)
            notes += (UNPAINTED,) if why is None and len(painted) < len(pieces) else ()
        else:
            picture, uv = first, np.concatenate([piece.uv for piece in painted if piece.uv is not None])
    colours, more = _colours(pieces)
    return Piece(vertices, faces, colours, None if picture is None else uv, picture), notes + (
        more if not picture else ()
    )


def _placed_or_not(piece: Piece) -> tuple[Piece, ...]:
    """The piece, split into faces with and without texture coordinates where some corners have none."""
    if piece.uv is None or piece.picture is None:
        return (replace(piece, uv=None, picture=None),)
    has_place: Booleans = np.all(np.isfinite(piece.uv)[piece.faces], axis=(1, 2))
    if has_place.all():
        return (piece,)
    without = replace(part(piece, ~has_place), uv=None, picture=None)
    return (part(piece, has_place), without) if has_place.any() else (without,)


def _colours(pieces: list[Piece]) -> tuple[NDArray[np.uint8] | None, tuple[str, ...]]:
    """(V, 3) of all pieces' vertices and what there is to say; None where nothing differs in colour."""
    own = [piece.colours for piece in pieces]
    is_one_colour = len({piece.tint for piece in pieces}) == 1 or any(piece.picture for piece in pieces)
    if all(colours is None for colours in own) and is_one_colour:
        return None, ()
    plain = [piece.tint or (UNCOLOURED,) * 3 for piece in pieces]
    filled = [
        np.full((len(piece.vertices), 3), tint, np.uint8) if piece.colours is None else piece.colours
        for piece, tint in zip(pieces, plain, strict=True)
    ]
    is_partly = any(piece.colours is None and piece.tint is None for piece in pieces)
    return np.concatenate(filled), (PARTLY_COLOURED,) if is_partly else ()


def _without_bad_vertices(whole: Piece) -> tuple[Piece, tuple[str, ...]]:
    """The triangles whose corners are places, and what was left out; BadScan when they are too many."""
    sound: Booleans = np.all(np.abs(whole.vertices) < BEYOND, axis=1)  # false for what is no number, too
    if sound.all():
        return whole, ()
    kept: Booleans = np.all(sound[whole.faces], axis=1)
    used = np.zeros(len(sound), np.bool_)
    used[whole.faces] = True
    bad, lost = int((used & ~sound).sum()), int((~kept).sum())
    if not bad:
        return part(whole, kept), ()
    which = "One vertex of this scan is" if bad == 1 else f"{bad:,} vertices of this scan are"
    if lost > BROKEN * len(kept):
        raise BadScan(f"{which} {NO_PLACES}; repair the mesh or export it again.")
    gone = "triangle that uses it was" if lost == 1 else f"{lost:,} triangles there were"
    return part(whole, kept), (f"{which} {NO_PLACES}; the {gone} left out.",)


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
    """Raises BadScan or TooLarge unless the scan has an allowed number of triangles."""
    if not len(whole.faces):
        what = "only points" if has_points else "no triangles"
        raise BadScan(f"This scan has {what}; export it as a triangle mesh.")
    if len(whole.faces) > TRIANGLES:
        raise TooLarge(TOO_MANY_TRIANGLES)
    if len(whole.faces) < MIN_TRIANGLES:
        count = "1 triangle" if len(whole.faces) == 1 else f"{len(whole.faces)} triangles"
        raise BadScan(f"This scan has only {count}, too few to show a torso; export the whole mesh.")


def _extent(vertices: Array, faces: Integers) -> float:
    """The extent of the triangles, in the vertices' unit."""
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
    """A note where the scan lies so far from the origin that single precision rounds its file or its display."""
    reach = float(np.abs(vertices).max())
    if metres * reach <= EXACT_WITHIN:
        return ()
    where = f"The scan lies {metres * reach:,.0f} m from the origin of its coordinates"
    if np.array_equal(vertices, vertices.astype(np.float32)):
        step = 1e3 * metres * float(np.spacing(np.float32(reach)))
        return (f"{where}, and its file rounds them to {step:.2g} mm; move it to the origin before it is exported.",)
    step = 1e3 * float(np.spacing(np.float32(metres * reach)))
    return (f"{where}; results are exact there, but pictures of it may be rounded to {step:.2g} mm.",)
