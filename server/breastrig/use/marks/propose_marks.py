"""Pairs of marks that the colours of two scans show: proposed, and followed once a person has accepted them."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from breastrig.core.arrays import Array, frozen
from breastrig.core.errors import BadInput, BadScan
from breastrig.core.one_thread import one_thread
from breastrig.drawings.marks.mark_pairs import SmallMarks, followed, paired
from breastrig.files.result import BODY, RESULT, UNCERTAINTY
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.scan.hand_cuts import without_hand_cuts
from breastrig.scan.read import coloured_scan
from breastrig.scan.scan import Scan as ScanInMetres
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of
from breastrig.use.folder.one_body import check_one_body
from breastrig.use.scan import Scan, ScanSource
from breastrig.use.transfer import folder_of
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model, loaded

if TYPE_CHECKING:
    from breastrig.colour.spots import ColourSpot

READ = ("scan.ply", "fitted.ply", UNCERTAINTY, BODY, RESULT)


@dataclass(frozen=True, eq=False)
class ProposedMark:
    """A small mark that two scans seem to share."""

    name: str  # m1, m2, ...; no mark of either scan has it
    kind: str  # what it looks like on the first scan: dot, cross (of a pen) or mole
    source: Array  # (3,) on the first scan, in its unit and frame
    target: Array  # (3,) on the second, likewise
    off_mm: float  # on the second scan, from where it was expected
    error_mm: float  # 90 % radius of that


class ProposedMarks(tuple[ProposedMark, ...]):
    """The pairs, surest first."""

    says: str  # how many small marks each scan shows, and how many pairs there are; one sentence


def propose_marks(
    source: Fit | str | Path,
    target: Fit | str | Path,
    source_scan: Scan | str | Path,
    target_scan: Scan | str | Path,
    *,
    same_patient: bool = False,
    model: Model = None,
) -> ProposedMarks:
    """Moles, dots and crosses of a pen that two coloured scans of one patient share, for a person to accept.

    `source` and `target` are the fits, or their folders, of the two scans; each `source` (3,) and `target` (3,) of the
    answer is in its scan's unit and frame.  Nothing follows what is proposed: give `fit` those that are right, as
    `marks`, for both scans.  `same_patient` and `model` are as in `transfer`.

    Raises BadScan for a scan without colour or with coarse colours, BadInput for one that is not the fit's; NeedsYes
    where the scans look like two patients'.
    """
    given = [each.model for each in (source, target) if isinstance(each, Fit)]
    rig = given[0] if model is None and given else loaded(model)
    with ExitStack() as stack, one_thread():
        fits = [fit_folder_of(stack.enter_context(folder_of(each, READ)), rig) for each in (source, target)]
        scans = [
            ScanSource(scan, "auto" if isinstance(scan, Scan) else fit.unit).read()[0]
            for scan, fit in zip((source_scan, target_scan), fits, strict=True)
        ]
        return _between(rig, fits, scans, same_patient)


@dataclass(frozen=True)
class ScanFile:
    """The stored scan of a fit."""

    file: Path
    file_type: str
    units: str
    cuts: tuple[dict[str, Any], ...] = ()


@dataclass(frozen=True)
class MarksJob:
    """Two fits of a service, and their scans."""

    fits: tuple[Path, Path]
    scans: tuple[ScanFile, ScanFile]
    marks: tuple[Mapping[str, Sequence[float]], Mapping[str, Sequence[float]]]  # mm, that the scans have by now
    model: Path | None = None  # None: the torso of the package
    one_patient: bool = False


def propose_marks_on_files(job: MarksJob) -> dict[str, Any]:
    """{says, marks: [{name, kind, source, target (mm), off_mm, error_mm}]}, ready for JSON.

    Raises a BreastRigError with a sentence.
    """
    rig = read_rig(job.model or default_rig_path())
    try:
        fits = [
            replace(fit_folder_of(folder, rig), marks={name: 1e-3 * np.array(at) for name, at in marks.items()})
            for folder, marks in zip(job.fits, job.marks, strict=True)
        ]
        scans = [
            without_hand_cuts(coloured_scan(each.file, each.file_type, each.units), each.cuts) for each in job.scans
        ]
        return marks_document(_between(rig, fits, scans, job.one_patient), [1e3 * fit.metres_per_unit for fit in fits])
    except MemoryError as error:
        raise BadScan("Finding marks on these scans needs more memory than it may use; simplify them first.") from error


def marks_document(found: ProposedMarks, mm_per_unit: Iterable[float]) -> dict[str, Any]:
    """The pairs in mm, each in its scan's frame; `mm_per_unit` are of the two scans."""
    first, second = mm_per_unit
    marks = [
        {
            "name": each.name,
            "kind": each.kind,
            "source": np.round(first * each.source, 2).tolist(),
            "target": np.round(second * each.target, 2).tolist(),
            "off_mm": round(each.off_mm, 1),
            "error_mm": round(each.error_mm, 1),
        }
        for each in found
    ]
    return {"says": found.says, "marks": marks}


def _between(rig: Rig, fits: list[FitFolder], scans: list[ScanInMetres], one_patient: bool) -> ProposedMarks:
    from breastrig.colour.spots import find_spots  # scikit-image and SciPy's filters are for coloured scans only

    check_one_body(fits[0], fits[1], one_patient)
    ready = [_in_true_size(scan, fit) for scan, fit in zip(scans, fits, strict=True)]
    spots = [find_spots(scan) for scan in ready]
    small = [_small(each) for each in spots]
    a, b = (fit.fitted_scan for fit in fits)
    pairs = paired(rig, a, b, *small)
    names = (name for number in count(1) if (name := f"m{number}") not in a.marks.keys() | b.marks.keys())
    found = ProposedMarks(
        ProposedMark(
            name,
            spots[0][pair.here].kind,
            frozen(spots[0][pair.here].place / fits[0].metres_per_unit),
            frozen(spots[1][pair.there].place / fits[1].metres_per_unit),
            1e3 * pair.off,
            1e3 * pair.error,
        )
        for name, pair in zip(names, pairs, strict=False)
    )
    shown = [int(followed(rig, fit.fitted_scan, each).sum()) for fit, each in zip(fits, small, strict=True)]
    pairs_said = "1 pair is proposed; check it." if len(found) == 1 else f"{len(found)} pairs are proposed; check each."
    found.says = (
        f"The {fits[0].stance} scan shows {shown[0]} small marks in its colours, the {fits[1].stance} scan {shown[1]}: "
        + (pairs_said if found else "none of them are a sure pair. Place marks by hand.")
    )
    return found


def _in_true_size(scan: ScanInMetres, fit: FitFolder) -> ScanInMetres:
    """The scan in the size that was fitted; BadInput for another scan, and for a body that none shows."""
    if fit.result.predicted:
        raise BadInput(f"The {fit.stance} body is predicted; marks are found between two scans, so give their fits.")
    if scan.sha256 != fit.result.scan.sha256:
        raise BadInput(
            f"The {fit.stance} fit was made of another scan than the one given; give the file it was made of."
        )
    scale = fit.result.scale
    if scale is None or scan.true_size is not None:
        return scan
    return replace(scan, vertices=scale.factor * scan.vertices)


def _small(spots: "tuple[ColourSpot, ...]") -> SmallMarks:
    return SmallMarks(
        np.array([spot.place for spot in spots]).reshape(-1, 3),
        np.array([spot.size for spot in spots]),
        np.array([spot.colour for spot in spots]).reshape(-1, 3),
    )
