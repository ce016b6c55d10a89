"""The template of a fit's planned lines, from its folder; see report/guides/template.py."""

from dataclasses import replace

from scipy.spatial import cKDTree

from breastrig.core.errors import BadInput
from breastrig.drawings.prepare_polyline import prepared
from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.document import stance_said
from breastrig.report.guides.template import template
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of, still_visible
from breastrig.use.folder.whose import check_whose
from breastrig.use.reports.report import ReportJob, laid_plan, planned_lines, stance_of

NOT_USABLE = "This fit cannot be used: {why} No template is made of it."
SAID = {
    "check": "Check this fit first: ",
    "uncalibrated": "Not calibrated for this rig: how far off lines may be is not known.",
}


def template_pdf_of(job: ReportJob, rig: Rig | None = None) -> bytes:
    """The pages for the job's first fit; a second one is where items of the plan were made.

    Raises BadInput for a folder that is no fit, for a fit that cannot be used, and for lines that cannot be laid flat.
    """
    from breastrig.report.guides.template_pdf import template_pdf  # the typesetter is 80 MB

    rig = rig or read_rig(job.model or default_rig_path())
    fits = [fit_folder_of(each, rig) for each in (job.fit, job.other) if each is not None]
    if job.plan is not None:
        check_whose(job.plan, [each.result for each in fits], job.same_patient)
    cuts = job.cuts or ((),) * len(fits)
    fits = [still_visible(each, cut) for each, cut in zip(fits, cuts, strict=True)]
    fit, verdict = fits[0], fits[0].result.verdict
    if verdict is not None and verdict.level == "unusable":
        raise BadInput(NOT_USABLE.format(why=" ".join(verdict.reasons)))
    plan = laid_plan(rig, job.plan, fits, job.same_patient)[0] if job.plan is not None else next(iter(job.plans), None)
    missing = () if plan is None else tuple(each["reason"] for each in plan[0].get("missing", ()))
    level = "" if verdict is None else verdict.level
    said = [SAID[level] + " ".join(verdict.reasons if level == "check" else ())] if level in SAID and verdict else []
    said += ["This position is predicted, not scanned."] if fit.result.predicted else []
    said += [f"Not on this template: {reason}" for reason in dict.fromkeys(missing)]
    lines = tuple(line for line in planned_lines(job.fit, fit.unit, plan) if len(line) > 1)
    pieces, left_out = template(stance_of(fit, _with_points_between(fit, lines)))
    return template_pdf(pieces, stance_said(fit.result), job.identity, [*said, *left_out, *job.doubts])


def _with_points_between(fit: FitFolder, lines: tuple[Polyline, ...]) -> tuple[Polyline, ...]:
    """The lines along the skin, a few millimetres from point to point; each with the error of the nearest given one."""
    if not lines:
        return ()
    return tuple(
        line if given.error is None else replace(line, error=given.error[cKDTree(given.points).query(line.points)[1]])
        for line, given in zip(prepared(fit.rig, fit.fitted_scan, lines), lines, strict=True)
    )
