"""The report of one fit, or of two stances of one patient, from the folders that `breastrig fit` wrote."""

import io
import os
import zipfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

from breastrig.colour.areolae import areolae_of
from breastrig.core.arrays import Array
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadDrawing, BadInput
from breastrig.core.identity import UNNAMED, Identity
from breastrig.core.private_files import read_ordinary, write_files
from breastrig.drawings.drawing_file import FILE_BYTES, lines_on_scan, planned_on_scan, rounded_mm
from breastrig.drawings.line_error import drawn_error
from breastrig.drawings.plan_schema import PLAN_SCHEMA, PlanLine, checked_plan
from breastrig.files.result import Distances, ResultFile, damaged, folder_name, joint_covariance
from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.languages.catalogue import ENGLISH
from breastrig.report.document import PlannedItem, Reported, report_document, stance_names, stance_said
from breastrig.report.measures import measures
from breastrig.report.stance import Stance
from breastrig.report.table import contradictions, csv_bytes, flat_rows
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of, still_visible
from breastrig.use.folder.one_body import check_one_body, doubts_between
from breastrig.use.folder.whose import check_whose
from breastrig.use.lines.plan_on_fit import PlanLines, plan_document, plan_on_folders
from breastrig.use.lines.plan_words import NOT_DRAWN, planned_items
from breastrig.volume.tetrahedra import chest_wall


@dataclass(frozen=True)
class ReportJob:
    """A report of one fit or of two."""

    fit: Path  # folder of a fit
    other: Path | None = None  # of the same patient in another stance
    model: Path | None = None  # None: the torso of the package
    plans: tuple[PlanLines | None, ...] = ()  # of each fit: its lines, and whether they are all that is wanted
    plan: dict[str, Any] | None = None  # or the plan itself (breastrig/plan@1 or drawing@1), to be laid on each scan
    same_patient: bool = False  # a person has said that plan and scans are one patient's, whatever file and bodies say
    one_patient: bool = False  # that was said of these two scans, and is remembered: no doubt is left
    items: tuple[dict[str, Any], ...] = ()  # of the plan of which `plans` are the lines
    identity: Identity = UNNAMED
    doubts: tuple[str, ...] = ()  # whether both fits are of one patient
    cuts: tuple[tuple[dict[str, Any], ...], ...] = ()  # of each fit's scan, made by hand: what is not shown any more
    names_marks: bool = True  # False: for others to see
    language: str = ENGLISH  # of the pages


REPORT_RECORD = "report.json"
MEASURES_TABLE = "measures.csv"


def drawn_lines(folder: Path, unit: str) -> tuple[Polyline, ...]:
    """The lines of the folder's drawing.json, in metres, for a scan in this unit; none where there is no such file."""
    file = folder / "drawing.json"
    if not os.path.lexists(file):
        return ()
    try:
        return lines_on_scan(read_ordinary(file, FILE_BYTES), unit)
    except (OSError, BadDrawing) as error:
        raise BadInput(f"{folder.resolve().name}/drawing.json is damaged; fit the scan again.") from error


def laid_plan(
    rig: Rig, document: dict[str, Any], fits: Sequence[FitFolder], same_patient: bool = False
) -> tuple[PlanLines, ...]:
    """The plan on the scan of each of a patient's fits; what names no scan was made on the first one's.

    NeedsYes where two of them do not look like one patient's, unless a person says that they are.
    """
    for a, b in combinations(fits, 2):
        check_one_body(a, b, same_patient)
    plan = checked_plan(document, fits[0].unit)
    found = []
    for place, fit in enumerate(fits):
        others = [other for other in fits if other is not fit]
        laid = plan_on_folders(rig, plan, [(each, "") for each in (fit, *others)], home=0 if place == 0 else 1)
        found.append((plan_document(plan, fit, laid), True))
    return tuple(found)


def planned_lines(folder: Path, unit: str, plan: PlanLines | None) -> tuple[Polyline, ...]:
    """The lines on a fit's scan: the plan's, and the fit's own drawing where the plan does not include it."""
    if plan is None:
        return drawn_lines(folder, unit)
    document, is_whole = plan
    planned = planned_on_scan(document)
    if is_whole:
        return planned
    named = {line.name for line in planned}
    return (*(line for line in drawn_lines(folder, unit) if line.name not in named), *planned)


def _with_shapes(lines: tuple[Polyline, ...], plan: PlanLines | None) -> list[tuple[Polyline, Mapping[str, Any]]]:
    """The lines of `planned_lines`, each with its shape of the plan; the fit's own have none.  Names may be alike."""
    shapes = [] if plan is None else [shape for shape in plan[0]["shapes"] if shape["points"]]
    own: list[Mapping[str, Any]] = [{}] * (len(lines) - len(shapes))
    return list(zip(lines, [*own, *shapes], strict=True))


def _without_own_errors(lines: tuple[Polyline, ...], plan: PlanLines | None) -> tuple[Polyline, ...]:
    """The lines, without errors for those planned on this very scan: only transferred ones have an error there."""
    return tuple(
        line if shape.get("carried", True) else replace(line, error=None) for line, shape in _with_shapes(lines, plan)
    )


def _banded(lines: tuple[Polyline, ...], plan: PlanLines | None) -> tuple[Polyline, ...]:
    """The lines that have a band: what a hand has drawn on this very scan is where it was drawn."""
    return tuple(
        line
        for line, shape in _with_shapes(lines, plan)
        if shape.get("carried", True) or shape.get("kind") not in ("line", "note")
    )


def _in_words(job: ReportJob, plan: PlanLines | None, fit: FitFolder) -> tuple[PlannedItem, ...]:
    """The plan's items; none where there is no plan."""
    if plan is None:
        return ()
    missing = {each["item"]: str(each["reason"]) for each in plan[0].get("missing", ())}
    return planned_items(checked_plan(_plan_document(job)).items, plan[0], missing, fit)


def _depths(job: ReportJob, lines: tuple[Polyline, ...], plan: PlanLines | None) -> dict[str, float]:
    """m, of the lines that were drawn with one."""
    items = () if plan is None else checked_plan(_plan_document(job)).items
    said = {each.id: 1e-3 * each.depth_mm for each in items if isinstance(each, PlanLine) and each.depth_mm}
    return {line.name: said[shape["item"]] for line, shape in _with_shapes(lines, plan) if shape.get("item") in said}


def _plan_document(job: ReportJob) -> dict[str, Any]:
    return job.plan or {"schema": PLAN_SCHEMA, "unit": "mm", "items": list(job.items)}


def _lesions(plan: PlanLines | None) -> tuple[dict[str, Any], ...]:
    return () if plan is None else tuple(plan[0].get("lesions", ()))


def stance_of(fit: FitFolder, lines: tuple[Polyline, ...] = ()) -> Stance:
    """A fit as measures, pictures and exports want it."""
    return Stance(
        rig=fit.rig,
        vertices=fit.vertices,
        scan_vertices=fit.surface.vertices,
        scan_faces=fit.surface.faces,
        name=fit.stance,
        picked=fit.landmarks,
        seen=fit.seen,
        lines=lines,
        landmark_radii={name: 1e-3 * radius for name, radius in fit.result.landmark_uncertainty_mm.items()},
        joint=_joint(fit.result),
        areolae=areolae_of(fit.result, fit.metres_per_unit),
        radii=fit.radii,
        predicted=fit.result.predicted,
    )


def _joint(result: ResultFile) -> tuple[tuple[str, ...], Array] | None:
    names = tuple(result.landmark_uncertainty_mm)
    found = joint_covariance(result.landmark_covariance_mm2, len(names))
    return None if found is None else (names, 1e-6 * found)


def reported(job: ReportJob, rig: Rig | None = None) -> list[Reported]:
    """Reads and measures; BadInput says what is wrong with a folder.  `rig` is that of the job, read already."""
    rig = rig or read_rig(job.model or default_rig_path())
    folders = [job.fit] if job.other is None else [job.fit, job.other]
    whole = [fit_folder_of(folder, rig) for folder in folders]
    if job.plan is not None:
        check_whose(job.plan, [fit.result for fit in whole], job.same_patient)
    fits = [still_visible(fit, cuts) for fit, cuts in zip(whole, job.cuts or ((),) * len(whole), strict=True)]
    plans = (
        laid_plan(rig, job.plan, fits, job.same_patient) if job.plan is not None else (job.plans or (None,) * len(fits))
    )
    for folder, fit in zip(folders, fits, strict=True):
        _check_distances(folder, fit.result)
    drawn = [planned_lines(folder, fit.unit, plan) for folder, fit, plan in zip(folders, fits, plans, strict=True)]
    stances = [
        replace(stance_of(fit, _without_own_errors(lines, plan)), banded=_banded(lines, plan))
        for fit, lines, plan in zip(fits, drawn, plans, strict=True)
    ]
    doubts = (*job.doubts, *(doubts_between(fits[0], fits[1], job.one_patient) if len(fits) == 2 else ()))
    names = stance_names([stance_said(fit.result) for fit in fits])
    rows = [measures(stance) for stance in stances]
    doubts += contradictions(list(zip(names, rows, strict=True)))
    return [
        Reported(
            name,
            stance,
            fit.result if job.names_marks else fit.result.without_marks(),
            measured,
            _in_words(job, plan, fit),
            _lesions(plan),
            doubts,
            partial(_wall, fit),
            rounded_mm(drawn_error(lines)),
            _depths(job, lines, plan),
        )
        for name, stance, fit, measured, plan, lines in zip(names, stances, fits, rows, plans, drawn, strict=True)
    ]


def _wall(fit: FitFolder) -> Array | None:
    """(V, 3) m: the estimated chest wall; None for a rig whose inside nobody knows."""
    with suppress(BadInput):
        return chest_wall(fit.rig, fit.parameters, fit.vertices)
    return None


def _check_distances(folder: Path, result: ResultFile) -> None:
    """BadInput where a mean stands alone: its page shows the largest and the 95th percentile as well."""
    for name in ("surface_distance_mm", "scan_to_model_mm"):
        for said in (result, result.distances):
            found: Distances = getattr(said, name)
            if found.mean is not None and None in (found.p95, found.max):
                raise damaged(folder_name(folder), name)
    if result.landmark_distance_mm.mean is not None and result.landmark_distance_mm.max is None:
        raise damaged(folder_name(folder), "landmark_distance_mm")


def pdf_of(stances: list[Reported], job: ReportJob) -> bytes:
    from breastrig.report.pages.pdf import report_pdf  # the typesetter is 80 MB, and the server makes no PDF itself

    return report_pdf(stances, job.identity, job.language)


def _pages(stances: list[Reported], job: ReportJob) -> bytes:
    from breastrig.report.pages.pdf import report_pages  # likewise

    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as pages:  # PNG is packed already
        for number, page in enumerate(report_pages(stances, job.identity, job.language), 1):
            pages.writestr(f"{number}.png", page)
    return packed.getvalue()


def measures_csv_of(job: ReportJob) -> bytes:
    """The table of measures alone: what each row of a batch gets."""
    return _measures_csv(reported(job))


def _measures_csv(stances: list[Reported]) -> bytes:
    verdicts = {each.name: each.result.verdict.level if each.result.verdict else "" for each in stances}
    return csv_bytes(flat_rows([(each.name, each.rows) for each in stances]), verdicts)


def write_three_files(job: ReportJob, folder: Path, pdf_name: str, rig: Rig | None = None) -> tuple[str, ...]:
    """Writes the three files; returns why patterns and items are not drawn, a sentence each.

    BadInput when the folder cannot be written.
    """
    stances = reported(job, rig)
    files = {
        REPORT_RECORD: json_bytes(report_document(stances)),
        MEASURES_TABLE: _measures_csv(stances),
        pdf_name: pdf_of(stances, job),
    }
    write_files(files, folder)
    planned = (each.said for stance in stances for each in stance.plan if each.said.startswith(NOT_DRAWN))
    return tuple(dict.fromkeys((*(why for stance in stances for why in stance.result.drawing_missing), *planned)))


def report_pdf_of(job: ReportJob) -> bytes:
    """The PDF alone: what the service's worker makes."""
    return _within_memory(lambda: pdf_of(reported(job), job))


def protocol_pdf_of(language: str = ENGLISH) -> bytes:
    """The page for taking scans with marks."""
    from breastrig.report.pages.protocol import protocol_pdf  # likewise

    return protocol_pdf(language)


def report_pages_of(job: ReportJob) -> bytes:
    """The pages as pictures: a zip of 1.png, 2.png, …"""
    return _within_memory(lambda: _pages(reported(job), job))


def measures_json_of(job: ReportJob) -> bytes:
    """report.json alone, likewise."""
    return _within_memory(lambda: json_bytes(report_document(reported(job), with_plan=False)))


def _within_memory(make: Callable[[], bytes]) -> bytes:
    try:
        return make()
    except MemoryError as error:
        raise BadInput("The report of this scan needs more memory than it may use; give a smaller scan.") from error
