"""A scan as programs see it: the file's own triangles, unit and frame."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

import breastrig.scan.read as scan_files
from breastrig.core.arrays import Array, Integers, frozen
from breastrig.core.errors import BadScan, BadSettings
from breastrig.core.private_files import is_folder, is_ordinary, shown
from breastrig.scan.hand_cuts import read_cuts, without_hand_cuts
from breastrig.scan.piece import TakenSegment
from breastrig.scan.read import coloured_scan
from breastrig.scan.scan import Scan as ScanInMetres
from breastrig.scan.stored_scan import read_stored
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers, checked_answers

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True, eq=False, repr=False)
class Scan:
    """V vertices and F triangles, as the scanner wrote them: not cleaned, not turned, not moved."""

    vertices: Array  # (V, 3) in `unit`, the scan's own frame
    faces: Integers  # (F, 3)
    colours: NDArray[np.uint8] | None  # (V, 3) sRGB
    unit: str  # m, dm, cm, mm, in or ft
    metres_per_unit: float
    unit_reason: str  # one sentence: how the unit was decided
    sha256: str  # of the file's bytes
    notes: tuple[str, ...]  # what reading found, one sentence each
    segments: tuple[TakenSegment, ...]  # of a label map: what each was taken for
    in_metres: ScanInMetres = field(repr=False)  # what a fit works on
    file: Path | None = field(repr=False)  # where it was read; no result replaces it

    @staticmethod
    def from_arrays(
        vertices: ArrayLike, triangles: ArrayLike, colours: ArrayLike | None = None, unit: str = "auto"
    ) -> "Scan":
        """A scan of a program's own: vertices (V, 3) in `unit`, triangles (F, 3) of their indices, counter-clockwise.

        colours   (V, 3) or (V, 4) sRGB: whole numbers 0 to 255, or others 0 to 1
        unit      of the vertices: m, dm, cm, mm, in, ft, or auto to decide from the size

        Raises BadScan, TooLarge or BadSettings (no such unit), each with one sentence.
        """
        places = _numbers(vertices, "vertices", (3,)).astype(np.float64)
        faces = _numbers(triangles, "triangles", (3,))
        if not np.array_equal(faces, np.rint(faces)):
            raise BadScan("triangles must be whole numbers, the indices of three vertices each.")
        if len(faces) and not 0 <= faces.min() <= faces.max() < len(places):
            raise BadScan("triangles name vertices that do not exist.")
        painted = None if colours is None else _numbers(colours, "colours", (3, 4))[:, :3]
        if painted is not None and len(painted) != len(places):
            raise BadScan(f"There are {len(painted)} colours for {len(places)} vertices; give one for each.")
        if painted is not None and painted.dtype.kind == "f":
            painted = np.rint(255.0 * np.clip(painted, 0.0, 1.0))
        tints = None if painted is None else painted.astype(np.uint8)
        return _scan(scan_files.scan_of_arrays(places, faces.astype(np.int64), tints, unit), None)

    @staticmethod
    def from_trimesh(mesh: "trimesh.Trimesh", unit: str = "auto") -> "Scan":
        """The scan of a trimesh.Trimesh with its vertex colours; `unit` auto is the mesh's own, where it names one.

        A texture is left out: save the mesh and give its file to `read_scan` to have it.  Raises as `from_arrays`.
        """
        visual = mesh.visual
        own = {"millimeters": "mm", "meters": "m", "centimeters": "cm", "decimeters": "dm", "inches": "in"}
        named = own.get(str(mesh.units), "auto") if unit == "auto" else unit
        colours = mesh.visual.vertex_colors if getattr(visual, "kind", None) == "vertex" else None
        return Scan.from_arrays(mesh.vertices, mesh.faces, colours, named)

    def without(self, cuts: str | Path | Mapping[str, Any]) -> "Scan":
        """The scan without what a person has cut away in the page: fits, proposals and ink do not see it.

        `cuts` is the path of a file with what `GET /api/scans/ID/cuts` answers, or that itself; they are lassos in
        metres of this scan's frame.  Triangles go, `vertices` stay as they are.

        Raises BadScan, with one sentence, for what holds no cuts, and where they leave next to nothing.
        """
        document = cuts if isinstance(cuts, Mapping) else Path(cuts)
        return _scan(without_hand_cuts(self.in_metres, read_cuts(document)), self.file)

    def with_lesions(
        self,
        *files: str | Path | bytes,
        frame: str | None = None,
        segments: Mapping[int, str] | None = None,
        same_place: bool | str | None = None,
    ) -> "Scan":
        """The scan of an image with the lesions of other files (NIfTI, NRRD, DICOM SEG, RTSTRUCT) that lie in it.

        frame        of NIfTI files, as in `read_scan`
        segments     number -> "lesion", "tissue" or "unused"
        same_place   whether the files lie where the image does, though they do not say so; None: it is asked

        Raises BadScan, TooLarge or BadSettings, each with one sentence; of BadScan NeedsAnswer, whose `question` has
        the choices.
        """
        from breastrig.scan.images.read_lesions import with_lesions  # volumes, which few scans are

        given = [each if isinstance(each, bytes) else existing(each) for each in files]
        answers = checked_answers(frame, segments, same_place=same_place)
        return _scan(with_lesions(self.in_metres, given, answers), self.file)

    def to_trimesh(self) -> "trimesh.Trimesh":
        """A copy as a trimesh.Trimesh, in the scan's unit and frame."""
        import trimesh  # 0.4 s, which most programs need not wait for

        return trimesh.Trimesh(self.vertices, self.faces, vertex_colors=self.colours, process=False)

    def __repr__(self) -> str:
        return f"<Scan: {len(self.vertices):,} vertices, {len(self.faces):,} triangles, in {self.unit}>"


def read_scan(
    source: str | Path | bytes,
    units: str = "auto",
    *,
    texture: bool = True,
    frame: str | None = None,
    segments: Mapping[int, str] | None = None,
    series: str | None = None,
    same_place: bool | str | None = None,
) -> Scan:
    """Reads PLY, OBJ, STL, GLB, OFF, 3MF, PCD, XYZ, USDZ, a label map (NIfTI, NRRD, MHA, DICOM SEG), or a zip of one of
    them with its pictures; or the bytes of such a file.

    `units` is the file's: m, dm, cm, mm, in, ft, or auto to decide from the size (`Scan.unit_reason` says how).
    A picture comes with it (`Scan.in_metres` has it, with its uv): fits and proposed landmarks look for areolae and
    navel in it, as they do where they are given the file.  `texture=False` leaves it out, which saves its decoding.
    A picture over a limit is left out, and `notes` say so.
    The scan's `vertices` (V, 3) are in the file's unit and frame; those of a label map in mm, LPS.

    `frame` is that of a volume (NIfTI, NRRD, MetaImage) that does not say where it lies, or says it twice: sform,
    qform, or three letters that say where the voxels' axes grow to, such as RAS.
    `segments` of a label map: number -> "lesion", "tissue" or "unused"; for others the file's codes and their form
    decide, and `Scan.segments` says what became of each.
    `series` is one of several in the DICOM files of an MRI: the `value` of a choice of NeedsAnswer.
    `same_place` says whether segmentations beside an image lie where it does, though they do not say so.

    Raises BadScan, TooLarge or BadSettings (no such unit, answers that do not fit the file), each with one sentence;
    of BadScan NeedsAnswer, whose `question` has the choices for `frame` or `series`.
    """
    file = None if isinstance(source, bytes) else existing(source)
    answers = checked_answers(frame, segments, series, same_place)
    given = source if isinstance(source, bytes) else Path(source)
    if texture:
        return _scan(coloured_scan(given, None, units, answers), file)
    return _scan(scan_files.read_scan(given, None, units, texture=False, answers=answers), file)


def read_coloured(source: str | Path, units: str = "auto", answers: VolumeAnswers = NOTHING_SAID) -> Scan:
    """The scan with its texture, for its colours only: a texture that is too large is left out."""
    return _scan(coloured_scan(existing(source), None, units, answers), existing(source))


def scan_of_stored(file: Path) -> Scan:
    """The stored scan of a case. Raises BadScan when it is damaged."""
    return _scan(read_stored(file, for_display=False), file)


def _scan(found: ScanInMetres, file: Path | None) -> Scan:
    return Scan(
        vertices=frozen(found.vertices / found.metres_per_unit),
        faces=found.faces,
        colours=found.colours,
        unit=found.unit,
        metres_per_unit=found.metres_per_unit,
        unit_reason=found.unit_reason,
        sha256=found.sha256,
        notes=found.notes,
        segments=found.segments,
        in_metres=found,
        file=file,
    )


def existing(file: str | Path) -> Path:
    """The path of a file, or of an MRI's folder; BadScan when there is none."""
    if not (is_ordinary(Path(file)) or is_folder(Path(file))):
        raise BadScan(f"There is no scan file {shown(file)}; check the name.")
    return Path(file)


def _numbers(given: ArrayLike, name: str, columns: tuple[int, ...]) -> NDArray[Any]:
    """A table with so many columns; BadScan says what is wrong with it."""
    try:
        found = np.asarray(given)
    except (TypeError, ValueError) as error:
        raise BadScan(f"{name} is no table of numbers.") from error
    if found.dtype.kind not in "fiu" or found.ndim != 2 or found.shape[1] not in columns:
        raise BadScan(f"{name} has the shape {found.shape} of {found.dtype}; it must be numbers (N, {columns[0]}).")
    return found


ScanLike: TypeAlias = "Scan | str | Path | trimesh.Trimesh"  # read already, a file, or a mesh of a program


class ScanSource:
    """A scan that has been read, or will be when it is needed: what else is wrong is better known before."""

    def __init__(
        self,
        scan: ScanLike,
        units: str,
        answers: VolumeAnswers = NOTHING_SAID,
        tell: Callable[[ScanInMetres], None] | None = None,
        lesions: Sequence[str | Path | bytes] = (),
    ) -> None:
        """`tell` is called with what has been read from a file, once; `lesions` are files drawn on the scan's image."""
        if not isinstance(scan, Scan | str | Path):
            scan, units = Scan.from_trimesh(scan, units), "auto"
        if isinstance(scan, Scan) and units != "auto":
            raise BadSettings("This scan has been read already; give its units to read_scan.")
        self._given = scan if isinstance(scan, Scan) else existing(scan)
        self._units, self._answers, self._tell = units, answers, tell
        self._lesions = [each if isinstance(each, bytes) else existing(each) for each in lesions]
        self._read = (scan.in_metres, 0.0) if isinstance(scan, Scan) and not lesions else None

    @property
    def file(self) -> Path | None:
        """The scan's file, if it is known."""
        return self._given.file if isinstance(self._given, Scan) else self._given

    @property
    def lesion_files(self) -> tuple[Path, ...]:
        """The files of lesions."""
        return tuple(each for each in self._lesions if isinstance(each, Path))

    def read(self) -> tuple[ScanInMetres, float]:
        """The scan, and the seconds that reading it took here."""
        if self._read is None:
            began = perf_counter()
            found = self._scan()
            if self._lesions:
                from breastrig.scan.images.read_lesions import with_lesions

                found = with_lesions(found, self._lesions, self._answers)
            self._read = found, perf_counter() - began
            if self._tell is not None:
                self._tell(found)
        return self._read

    def _scan(self) -> ScanInMetres:
        """The scan without lesions of other files."""
        if isinstance(self._given, Scan):
            return self._given.in_metres
        answers = self._answers.without_lesions if self._lesions else self._answers
        return coloured_scan(self._given, None, self._units, answers)
