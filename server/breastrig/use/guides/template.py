"""Template and guide of a fit's planned lines, from its folder; see report/guides/."""

from dataclasses import replace

from scipy.spatial import cKDTree

from breastrig.core.errors import BadInput
from breastrig.core.stances import SIDES
from breastrig.drawings.prepare_polyline import prepared
from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.document import stance_said
from breastrig.report.files.geometry_files import surface_stl
from breastrig.report.guides.template import template
from breastrig.report.stance import Stance
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of, still_visible
from breastrig.use.folder.whose import check_whose
from breastrig.use.reports.report import ReportJob, laid_plan, planned_lines, stance_of

HEADER = 80  # bytes of an STL


def template_pdf_of(job: ReportJob, rig: Rig | None = None) -> bytes:
    """The pages for the job's first fit; a second one is where items of the plan were made.

    Raises BadInput for a folder that is no fit, for a fit that cannot be used, and for lines that cannot be laid flat.
    """
    from breastrig.report.guides.template_pdf import template_pdf  # the typesetter is 80 MB

    fit, stance, said = _planned_stance(job, rig)
    pieces, left_out = template(stance)
    return template_pdf(pieces, stance_said(fit.result), job.identity, [*said, *left_out, *job.doubts], job.language)


def guide_stl_of(job: ReportJob, side: str, rig: Rig | None = None) -> bytes:
    """The guide of one side ("L" or "R") as binary STL, mm in the patient's frame; raises likewise.

    Its header says how far the arrow's tip is from the notch.
    """
    from breastrig.report.guides.shell import guide

    _, stance, _ = _planned_stance(job, rig)
    found = guide(stance, side)
    header = (
        f"Patient's {SIDES[side]}. Arrow's tip to notch: {1e3 * found.to_notch:.0f} mm along the skin. Research use."
    )
    return header.encode().ljust(HEADER)[:HEADER] + surface_stl(found.vertices, found.faces, 1e-3)[HEADER:]


def guide_said(content: bytes) -> str:
    """What the header of a guide says."""
    return content[:HEADER].decode().strip()


def _planned_stance(job: ReportJob, rig: Rig | None) -> tuple[FitFolder, Stance, list[str]]:
    """The job's first fit with the planned lines alone, and what is to be said of it."""
    rig = rig or read_rig(job.model or default_rig_path())
    fits = [fit_folder_of(each, rig) for each in (job.fit, job.other) if each is not None]
    if job.plan is not None:
        check_whose(job.plan, [each.result for each in fits], job.same_patient)
    cuts = job.cuts or ((),) * len(fits)
    fits = [still_visible(each, cut) for each, cut in zip(fits, cuts, strict=True)]
    fit, verdict = fits[0], fits[0].result.verdict
    level = "" if verdict is None else verdict.level
    reasons = "" if verdict is None else " ".join(verdict.reasons)
    if level == "unusable":
        raise BadInput(f"This fit cannot be used: {reasons} No template is made of it.")
    plan = laid_plan(rig, job.plan, fits, job.same_patient)[0] if job.plan is not None else next(iter(job.plans), None)
    missing = () if plan is None else tuple(each["reason"] for each in plan[0].get("missing", ()))
    said = [f"Check this fit first: {reasons}"] if level == "check" else []
    said += ["Not calibrated for this rig: how far off lines may be is not known."] if level == "uncalibrated" else []
    said += ["This position is predicted, not scanned."] if fit.result.predicted else []
    said += [f"Not on this template: {reason}" for reason in dict.fromkeys(missing)]
    lines = tuple(line for line in planned_lines(job.fit, fit.unit, plan) if len(line) > 1)
    return fit, stance_of(fit, _with_points_between(fit, lines)), said


def _with_points_between(fit: FitFolder, lines: tuple[Polyline, ...]) -> tuple[Polyline, ...]:
    """The lines along the skin, a few millimetres from point to point; each with the error of the nearest given one."""
    if not lines:
        return ()
    return tuple(
        line if given.error is None else replace(line, error=given.error[cKDTree(given.points).query(line.points)[1]])
        for line, given in zip(prepared(fit.rig, fit.fitted_scan, lines), lines, strict=True)
    )
