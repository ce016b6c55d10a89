"""A fit's folder turned into files for other programs (Blender, MeshLab, tetrahedral meshers)."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from breastrig.archive.patient_frame import moved, to_patient
from breastrig.archive.slicer import slicer_scene
from breastrig.core.documents import json_bytes
from breastrig.core.srgb import rgb
from breastrig.gltf.lines.lines_glb import lines_glb
from breastrig.report.files.exported import closed_model, vertex_sets
from breastrig.report.files.geometry_files import obj_lines, ply_lines, surface_ply, surface_stl
from breastrig.report.stance import places
from breastrig.use.folder.fit_folder import read_fit_folder
from breastrig.use.folder.whose import check_whose
from breastrig.use.reports.report import laid_plan, planned_lines, stance_of

EXPORT_RECORD = "surface.json"
SLICER = "scene.mrb"
EXPORT_FILES = (SLICER, "drawing.glb", "drawing.obj", "drawing.ply", "surface.ply", "surface.stl", EXPORT_RECORD)


def export_files(
    folder: Path,
    model: Path | None = None,
    plan: dict[str, Any] | None = None,
    other: Path | None = None,
    same_patient: bool = False,
    slicer: bool = False,
) -> dict[str, bytes]:
    """drawing.{glb,obj,ply}, where something is drawn, and surface.{ply,stl,json}; by name.

    With `slicer` also scene.mrb, in mm along the patient's axes (LPS).

    Drawn is the `plan` (a document), carried from the fit `other` where it was made there; else the fit's own drawing.

    Everything is in the scan's frame and unit, apart from drawing.glb, which is in metres as glTF demands.
    Raises BadInput for a folder that is no fit, of it NeedsYes for another patient's plan, and for two fits that
    do not look like one patient's, unless `same_patient`.
    """
    fit = read_fit_folder(folder, model)
    fits = [fit] if other is None else [fit, read_fit_folder(other, model)]
    if plan is not None:
        check_whose(plan, [each.result for each in fits], same_patient)
    laid = None if plan is None else laid_plan(fit.rig, plan, fits, same_patient)[0]
    stance = stance_of(fit, planned_lines(folder, fit.unit, laid))
    per_unit, unit = fit.metres_per_unit, fit.unit
    files = {}
    if stance.lines:
        named = [(line.name, line.points, line.closed, rgb(line.color)) for line in stance.lines]
        files["drawing.glb"] = lines_glb(named, {"unit": "m", "scan_unit": unit})
        files["drawing.obj"] = obj_lines(stance.lines, per_unit, unit)
        files["drawing.ply"] = ply_lines(stance.lines, per_unit, unit)
    closed = closed_model(stance)
    files["surface.ply"] = surface_ply(closed.surface.vertices, closed.surface.faces, per_unit)
    files["surface.stl"] = surface_stl(closed.surface.vertices, closed.surface.faces, per_unit)
    files["surface.json"] = json_bytes(vertex_sets(stance, closed, unit))
    if slicer:
        matrix = to_patient(stance, fit.result)
        surfaces = {"skin": (moved(matrix, stance.vertices), stance.rig.faces)}
        if not stance.predicted:
            surfaces["scan"] = (moved(matrix, stance.scan_vertices), stance.scan_faces)
        landmarks = {name: moved(matrix, place.point) for name, place in places(stance).items()}
        lines = [replace(line, points=moved(matrix, line.points)) for line in stance.lines]
        files[SLICER] = slicer_scene(surfaces, landmarks, lines)
    return files
