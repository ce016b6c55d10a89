"""The files of a finished fit (paragraph 5 of the specification)."""

from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import distribution
from pathlib import Path
from typing import Any, cast

import numpy as np

from breastrig.colour.areolae import areolae_document
from breastrig.core.arrays import Array, Integers
from breastrig.core.documents import json_bytes
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.private_files import write_files
from breastrig.core.stances import Stance
from breastrig.core.version import __version__
from breastrig.correspondence.distances import SurfaceDistances as FoundDistances
from breastrig.correspondence.distances import (
    landmark_summary_mm,
    summary_mm,
    surface_summary_mm,
)
from breastrig.drawings.drawing_file import rounded_mm, shape_document
from breastrig.drawings.line_error import drawn_error
from breastrig.files.result import (
    BODY,
    CHECKS,
    FIT_FILES,
    RESULT,
    UNCERTAINTY,
    DoubtedPick,
    MedianPlane,
    ModelAlone,
    ModelSummary,
    ResultBone,
    ResultFile,
    ResultLesion,
    ResultMark,
    ResultParameters,
    ResultScale,
    ResultScan,
    ResultWall,
    Unit,
    Verdict,
)
from breastrig.fitting.checks.basis import basis_bytes
from breastrig.fitting.hypotheses import UNCLEAR
from breastrig.fitting.posterior import contribution_bytes
from breastrig.fitting.task import PickIssue
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.rotations import quaternion_from_rotation
from breastrig.gltf.replay import fitted_glb
from breastrig.least_squares.newton import Status
from breastrig.report.body_frame import body_frame
from breastrig.report.files.geometry_files import surface_ply
from breastrig.rig.arms import arm_angles
from breastrig.rig.known import NOT_CALIBRATED
from breastrig.use.steps.outcome import FitOutcome

OFF_SKIN = 0.01  # m from the scan; a mark farther off is on no skin that the scan shows


def _rounded(values: Array, digits: int = 6) -> list[float]:
    return [round(float(value), digits) for value in np.asarray(values).ravel()]


def _doubted(doubt: PickIssue) -> DoubtedPick:
    return DoubtedPick(names=list(doubt.names), reason=doubt.reason)


def _in_mm(values: Mapping[str, float]) -> dict[str, float]:
    return {name: round(1e3 * value, 2) for name, value in values.items()}


def _upper_mm2(joint: Array) -> list[float]:
    return _rounded(1e6 * joint[np.triu_indices(len(joint))], 3)


@cache
def library_versions() -> dict[str, str]:
    """Versions of the libraries that results name, from the heads of their metadata, which are long."""
    heads = {name: distribution(name).read_text("METADATA") or "" for name in ("numpy", "scipy", "trimesh")}
    return {name: head.partition("\nVersion: ")[2].partition("\n")[0].strip() for name, head in heads.items()}


def result_of(outcome: FitOutcome) -> ResultFile:
    """The fit's result.json."""
    ready, x, last = outcome.ready, outcome.parameters, outcome.recorded[-1].iterate
    plan, found, scan = ready.plan, ready.hypothesis, ready.scan
    task, rig = found.task, plan.rig
    per_unit = scan.metres_per_unit
    model_landmarks, alone_landmarks = (
        dict(zip(rig.landmark_names, rig.landmark_points().positions(vertices, rig.faces), strict=True))
        for vertices in (outcome.vertices, outcome.model_alone.vertices)
    )
    seen = {name: each.place for name, each in outcome.seen.items()}
    quaternions = quaternion_from_rotation(x.rotations)
    shown = np.isfinite(outcome.distances.signed)
    return ResultFile(
        schema="breastrig/result@1",
        notice=LIMITS_OF_USE,
        scan=ResultScan(
            vertices=len(scan.vertices),
            triangles=len(scan.faces) + scan.cut_by_hand,
            unit=cast(Unit, scan.unit),
            unit_reason=scan.unit_reason,
            sha256=scan.sha256,
            table_triangles=ready.prepared.table_triangles,
            cut_by_hand_triangles=scan.cut_by_hand,
            reconstructed_from_points=scan.from_points,
            cut_away_cm2=round(1e4 * ready.prepared.cut_away),
        ),
        model=ModelSummary(
            name=rig.name,
            sha256=rig.sha256,
            vertices=len(rig.template),
            bones=len(rig.bones),
            blendshapes=len(rig.shapes),
        ),
        stance=cast(Stance, task.stance),
        stance_reason=found.stance_reason,
        stance_asked=found.stance_reason in UNCLEAR,
        preset=task.recipe.name,
        refined=plan.settings.refine,
        converged=last.status is Status.CONVERGED,
        stop_reason=last.status.value,
        verdict=Verdict(level=outcome.verdict.level, reasons=outcome.verdict.reasons, about=outcome.verdict.about),
        iterations=last.iteration,
        timing_s={name: round(seconds, 4) for name, seconds in outcome.timing_s.items()},
        **_distances(outcome.distances, model_landmarks, plan.landmarks),
        model_alone=ModelAlone(**_distances(outcome.model_alone.distances, alone_landmarks, plan.landmarks)),
        landmarks_not_followed=[_doubted(doubt) for doubt in outcome.doubts if not doubt.followed],
        landmarks_unusual=[_doubted(doubt) for doubt in outcome.doubts if doubt.followed],
        not_calibrated=None if outcome.radii else f"{NOT_CALIBRATED}: how far off its fits are is not known.",
        median_plane=_median_plane(outcome),
        landmark_uncertainty_mm={} if outcome.radii is None else _in_mm(outcome.radii.landmarks),
        landmark_covariance_mm2=[] if outcome.radii is None else _upper_mm2(outcome.radii.joint),
        line_error_mm=None if outcome.radii is None else rounded_mm(outcome.radii.lines),
        drawn_line_error_mm=rounded_mm(drawn_error(outcome.lines)),
        arm_angles_deg={side: round(angle) for side, angle in arm_angles(rig, x, shown).items()},
        landmarks_agreed=list(plan.unsure),
        landmarks={name: _rounded(place / per_unit) for name, place in (model_landmarks | seen).items()},
        landmarks_seen={name: each.reason for name, each in outcome.seen.items()},
        landmarks_picked={name: _rounded(place / per_unit) for name, place in plan.landmarks.items()},
        scale=_scale(outcome),
        size_known=scan.size_known,
        marks=_marks(outcome),
        marks_asked=_marks_asked(outcome),
        areolae=areolae_document(outcome.areolae, per_unit),
        lesions=[
            ResultLesion(name=each.name, center=_rounded(each.center / per_unit), radius_mm=round(1e3 * each.radius, 3))
            for each in scan.lesions
        ],
        wall=None if scan.wall is None else _wall(scan.wall, per_unit),
        parameters=ResultParameters(
            bones=[
                ResultBone(
                    name=name,
                    rotation_xyzw=_rounded(quaternions[j], 9),
                    translation_m=_rounded(x.translations[j], 9),
                    scale=_rounded(x.scales[j], 9),
                )
                for j, name in enumerate(rig.bone_names)
            ],
            blendshapes=dict(zip(rig.shape_names, _rounded(x.weights, 9), strict=True)),
        ),
        drawing_missing=list(outcome.drawing_missing),
        notes=list(ready.notes),
        versions={"breastrig": __version__} | library_versions(),
    )


def _wall(wall: tuple[Array, Integers], per_unit: float) -> ResultWall:
    points = np.round(wall[0] / per_unit, 1 + round(np.log10(1e3 * per_unit)))  # to 0.1 mm
    return ResultWall(points=points.tolist(), triangles=wall[1].tolist())


def _distances(found: FoundDistances, model: Mapping[str, Array], picked: Mapping[str, Array]) -> dict[str, Any]:
    """Between scan and model, both ways, and between landmarks (m)."""
    return {
        "surface_distance_mm": surface_summary_mm(found.model),
        "scan_to_model_mm": summary_mm(found.scan),
        "landmark_distance_mm": landmark_summary_mm(model, picked),
    }


def _scale(outcome: FitOutcome) -> ResultScale | None:
    size = outcome.ready.scan.true_size
    if size is None:
        return None
    between = [size.length.start, size.length.end]
    return ResultScale(
        factor=round(size.factor, 9), between=between, mm=size.length.mm, measured_mm=round(size.measured_mm, 4)
    )


def _marks(outcome: FitOutcome) -> dict[str, ResultMark]:
    """Each mark as given, and the point of the fitted model's skin that is nearest to it."""
    marks, per_unit = outcome.ready.plan.marks, outcome.ready.scan.metres_per_unit
    if not marks:
        return {}
    at = ClosestPointSearch(outcome.vertices, outcome.ready.plan.rig.faces).query(np.array(list(marks.values())))
    return {
        name: ResultMark(
            point=_rounded(place / per_unit),
            off_scan_mm=round(1e3 * float(gap), 3),
            face=int(face),
            barycentric=_rounded(barycentric),
        )
        for (name, place), gap, face, barycentric in zip(
            marks.items(), _off_scan(outcome), at.faces, at.barycentric, strict=True
        )
    }


def _off_scan(outcome: FitOutcome) -> Array:
    """(M,) m from each mark to the scan's surface."""
    return outcome.ready.prepared.target.search.query(np.array(list(outcome.ready.plan.marks.values()))).distances


def _marks_asked(outcome: FitOutcome) -> list[DoubtedPick]:
    if not outcome.ready.plan.marks:
        return []
    return [
        DoubtedPick(
            names=[name],
            reason=f"The mark {name} is {1e3 * gap:.0f} mm off the scan's skin and is not followed; place it again.",
        )
        for name, gap in zip(outcome.ready.plan.marks, _off_scan(outcome).tolist(), strict=True)
        if gap > OFF_SKIN
    ]


def _median_plane(outcome: FitOutcome) -> MedianPlane:
    frame = body_frame(outcome.ready.plan.rig, outcome.vertices)
    normal = frame.axes[:, 0]
    offset = float(normal @ frame.middle) / outcome.ready.scan.metres_per_unit
    return MedianPlane(normal=_rounded(normal, 9), offset=round(offset, 6))


def drawing_json(outcome: FitOutcome) -> dict[str, object]:
    """The drawing on the scan, in the scan's frame and unit."""
    return {
        "schema": "breastrig/drawing@1",
        "name": outcome.drawing.name if outcome.drawing else None,
        "unit": outcome.ready.scan.unit,
        "notice": LIMITS_OF_USE,
        "scan_sha256": outcome.ready.scan.sha256,
        "shapes": [shape_document(line, outcome.ready.scan.metres_per_unit) for line in outcome.lines],
    }


def distances_bin(outcome: FitOutcome) -> bytes:
    """Signed distance of each model vertex to the scan: little-endian float32, mm, nan where no pair was accepted.

    Above zero the model lies outside the scan's skin.
    """
    return (1e3 * outcome.distances.signed).astype("<f4").tobytes()


def uncertainty_bin(outcome: FitOutcome) -> bytes:
    """90 % radius of each model vertex: float32 as above, mm.

    All nan for a rig without a calibration, which result.json states in words (not_calibrated).
    """
    unknown = np.full(len(outcome.vertices), np.nan)
    return (1e3 * (unknown if outcome.radii is None else outcome.radii.vertices)).astype("<f4").tobytes()


def fit_file(outcome: FitOutcome, name: str) -> bytes:
    """The content of one of FIT_FILES."""
    return MAKERS[name](outcome)


def write_fit_files(outcome: FitOutcome, folder: Path) -> ResultFile:
    """Writes all FIT_FILES; returns the result. BadInput when the folder cannot be written."""
    files = {name: MAKERS[name](outcome) for name in FIT_FILES if name != RESULT}
    result = result_of(outcome).beside(files)
    write_files(files | {RESULT: result.content()}, folder)
    return result


def _scan_ply(outcome: FitOutcome) -> bytes:
    """The cleaned scan, in its own frame and unit."""
    target = outcome.ready.prepared.target
    return surface_ply(target.vertices, target.faces, outcome.ready.scan.metres_per_unit)


def _fitted_ply(outcome: FitOutcome) -> bytes:
    return surface_ply(outcome.vertices, outcome.ready.plan.rig.faces, outcome.ready.scan.metres_per_unit)


def _fitted_glb(outcome: FitOutcome) -> bytes:
    task = outcome.ready.hypothesis.task
    has_layer = outcome.ready.plan.settings.refine or len(outcome.recorded[-1].iterate.parameters.modes) > 0
    surface = outcome.vertices if has_layer else None
    history = [each.iterate.parameters.without_modes for each in outcome.recorded]
    times_s = [each.iterate.elapsed_s for each in outcome.recorded]
    return fitted_glb(task.rig, history, times_s, outcome.drawing, {"preset": task.recipe.name}, surface)


def _log(outcome: FitOutcome) -> bytes:
    events = (each.event for each in outcome.recorded)
    return "".join(event.model_dump_json(exclude={"nodes", "modes"}) + "\n" for event in events).encode()


MAKERS: dict[str, Callable[[FitOutcome], bytes]] = {
    "scan.ply": _scan_ply,
    "fitted.ply": _fitted_ply,
    "fitted.glb": _fitted_glb,
    "drawing.json": lambda outcome: json_bytes(drawing_json(outcome)),
    "distances.bin": distances_bin,
    UNCERTAINTY: uncertainty_bin,
    BODY: lambda outcome: contribution_bytes(outcome.body),
    CHECKS: lambda outcome: basis_bytes(outcome.checks),
    "fit.log.jsonl": _log,
    RESULT: lambda outcome: result_of(outcome).content(),  # alone: hashes of the others come when all are written
}
assert tuple(MAKERS) == FIT_FILES
