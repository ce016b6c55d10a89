"""A drawing made on the scan of one fit, shown on the scan of another: of fits in memory or in folders.

It reads two scans and solves a small dense system, about a second of work in all, so the service runs it in a
process of its own, as it does with everything that reads scans.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadDrawing, BadInput
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.one_thread import one_thread
from breastrig.core.private_files import write_files
from breastrig.core.scratch import scratch_folder
from breastrig.drawings.drawing_file import Drawing as DrawingFile
from breastrig.drawings.drawing_file import (
    drawing_document,
    lines_on_scan,
    millimetres,
    parsed_drawing,
    shape_document,
)
from breastrig.drawings.on_skin import moved_onto_skin
from breastrig.drawings.plan_schema import PLAN_SCHEMA, Plan, PlanLine, checked_plan, is_plan
from breastrig.drawings.project_drawing import on_scan
from breastrig.drawings.transfer import TransferredLine, transferred
from breastrig.files.result import BODY, FIT_FILES, RESULT, UNCERTAINTY
from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.use.draw import Drawn, drawn_items
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of
from breastrig.use.folder.one_body import check_one_body, doubts_between
from breastrig.use.folder.whose import check_whose, made_on
from breastrig.use.lines.marks_between import marks_between
from breastrig.use.lines.plan_on_fit import items_of, lesions_of, plan_document, plan_on_folders, scan_of_plan
from breastrig.use.values.drawing import Drawing, Lesion, Line, document_of, drawing_of
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model, loaded

READ = ("scan.ply", "fitted.ply", UNCERTAINTY, BODY, RESULT)  # what a transfer reads of a fit


def transfer(
    source: Fit | str | Path,
    target: Fit | str | Path,
    drawing: Drawn | None = None,
    *,
    other_patient: bool = False,
    same_patient: bool = False,
    model: Model = None,
) -> Drawing:
    """A drawing made on the scan of one fit, shown on the scan of another, in that scan's unit and frame.

    Args:
        source: The fit, or its folder, on whose scan the drawing was made.
        target: The fit, or its folder, on whose scan it is shown.
        drawing: `Line` objects with points (M, 3) and `Lesion` objects, in the source scan's unit and frame; a
            `Drawing`; a document breastrig/drawing@1 or plan@1, or the path of one; None: the drawing that the first
            fit has.
        other_patient: Whether the scans are of two patients: the same place of the model instead of the same skin.
        same_patient: Whether drawing and scans are one patient's, though its file names another's code and scan, or the
            bodies of both fits do not look like one.
        model: Of folders, where it is not the package's; a `Fit` has its own.

    Returns:
        Lines with more points than before; `bridged` (M,) says where the target's scan has a hole, and
        `distance_from_mm`, `distance_to_mm` (M,) how far both fits were from their scans there, and `error_mm` (M,)
        the radius that holds each point's true place with 90 %.  `document["moved"]` says which given points were moved
        onto the skin.

    Raises:
        BadInput: BadDrawing or another, with one sentence; NeedsYes where `same_patient` has to be said.
    """
    own = {each.model.sha256: each.model for each in (source, target) if isinstance(each, Fit)}
    rigs = own if model is None and own else own | {(given := loaded(model)).sha256: given}
    if len(rigs) > 1:
        raise BadInput(f"The fits were made with several models ({_names(rigs)}); fit both scans with one.")
    [rig] = rigs.values()
    document, inputs = _document(source, drawing, rig)
    inputs += tuple(Path(each) / name for each in (source, target) if not isinstance(each, Fit) for name in FIT_FILES)
    with ExitStack() as stack:
        folders = [
            stack.enter_context(folder_of(each, READ if document is not None else (*READ, "drawing.json")))
            for each in (source, target)
        ]
        with one_thread():
            found = carried_drawing(
                folders[0],
                folders[1],
                document,
                rig=rig,
                other_patient=other_patient,
                same_patient=same_patient,
                one_patient=same_patient,
            )
    return drawing_of(found, inputs)


def _names(rigs: Mapping[str, Rig]) -> str:
    return ", ".join(f"{rig.name} {sha256[:12]}" for sha256, rig in rigs.items())


def _document(
    source: Fit | str | Path, drawing: Drawn | None, rig: Rig
) -> tuple[dict[str, Any] | None, tuple[Path, ...]]:
    """The drawing as a document, None for the source's own; and the files that it is from."""
    if drawing is None:
        return None, ()
    if isinstance(drawing, str | Path):
        return drawing_document(Path(drawing)), (Path(drawing),)
    if isinstance(drawing, Mapping):
        return dict(drawing), ()
    inputs = drawing.inputs if isinstance(drawing, Drawing) else ()
    if isinstance(drawing, Drawing):
        if not drawing.lesions:
            return drawing.document, inputs
        projected = {each["name"] for each in drawing.document["shapes"] if each.get("kind") == "lesion"}
        drawing = [*(line for line in drawing.lines if line.name not in projected), *drawing.lesions]
    given = [drawing] if isinstance(drawing, Line | Lesion) else drawing
    lines = [each for each in given if not isinstance(each, Lesion)]
    if len(lines) == len(given):
        return document_of(lines), inputs
    fit = (source if isinstance(source, Fit) else Fit.load(source, rig)).in_metres
    return {"schema": PLAN_SCHEMA, "items": drawn_items(given, fit)}, inputs


@contextmanager
def folder_of(fit: Fit | str | Path, names: Sequence[str]) -> Iterator[Path]:
    """A folder with these files of the fit; for the moment, where it has none."""
    if not isinstance(fit, Fit):
        yield Path(fit)
        return
    with scratch_folder() as folder:
        write_files(fit.files.several(names), folder)
        yield folder


def carried_drawing(
    from_fit: Path,
    to_fit: Path,
    drawing: dict[str, Any] | None,
    *,
    rig: Rig,
    other_patient: bool = False,
    same_patient: bool = False,
    one_patient: bool = False,
) -> dict[str, Any]:
    """A drawing on the scan of the fit in one folder, on that of another (breastrig/drawing@1), in its frame and unit.

    `drawing` is a document breastrig/drawing@1 or breastrig/plan@1; None: the one that the first fit left.  A person
    may have said that it is this `same_patient`'s, whatever its file says, and that both scans are of `one_patient`,
    whatever their bodies say.

    Raises BadInput, of it NeedsYes for a drawing that is another patient's, and for scans that look like two patients'.
    """
    source, goal = fit_folder_of(from_fit, rig), fit_folder_of(to_fit, rig)
    if drawing is not None:
        check_whose(drawing, (source.result, goal.result), same_patient)
    if not other_patient:
        check_one_body(source, goal, one_patient)
    if drawing is not None and is_plan(drawing):
        return _plan_on(rig, checked_plan(drawing), source, goal, other_patient)
    if drawing is None and source.result.lesions and not other_patient:
        return _plan_on(rig, _with_lesions(from_fit, source), source, goal, other_patient=False)
    given = _own(from_fit, source) if drawing is None else parsed_drawing(drawing, rig, source.unit)
    a = source.fitted_scan
    b = goal.fitted_scan
    shapes = list(given.on_scan)
    if given.on_model:
        drawn = ModelDrawing(given.name, given.name, given.on_model)
        shapes += on_scan(rig, a.vertices, drawn, a.target)
    try:
        carried = transferred(rig, a, b, shapes, other_patient)
    except MemoryError as error:
        raise BadInput("Carrying this drawing needs more memory than it may use; give smaller scans.") from error
    doubts, marks = ([], {}) if other_patient else (doubts_between(source, goal), marks_between(source, goal))
    found = _carried_document(given, goal, carried, other_patient)
    return found | {"doubts": doubts, "moved": _moved(source, given.on_scan)} | ({"marks": marks} if marks else {})


def carried_between(
    from_fit: Path,
    to_fit: Path,
    drawing: dict[str, Any] | None,
    *,
    model: Path | None,
    other_patient: bool,
    one_patient: bool,
) -> dict[str, Any]:
    """`carried_drawing` of the fits of one service, which has asked whose drawing it is; None: the package's model."""
    rig = read_rig(model or default_rig_path())
    return carried_drawing(
        from_fit, to_fit, drawing, rig=rig, other_patient=other_patient, same_patient=True, one_patient=one_patient
    )


def _moved(source: FitFolder, lines: Iterable[Polyline]) -> list[str]:
    """A sentence for each line on the source's scan whose points were moved onto its skin."""
    search = source.fitted_scan.target.search
    said = (moved_onto_skin(line, search.query(line.points).distances) for line in lines)
    return [sentence for sentence in said if sentence is not None]


def _own(folder: Path, fit: FitFolder) -> DrawingFile:
    """The fit's own drawing, of any size."""
    document = drawing_document(folder / "drawing.json")
    lines = lines_on_scan(document, fit.unit)
    if not lines:
        raise BadDrawing("This fit has left no lines; give a drawing.")
    return DrawingFile(str(document.get("name") or "drawing"), lines, ())


def _with_lesions(folder: Path, fit: FitFolder) -> Plan:
    """A plan of the fit's own drawing and of what its label map shows inside."""
    lines = [each.model_dump(mode="json") for each in checked_plan(drawing_document(folder / "drawing.json")).items]
    return checked_plan({"schema": PLAN_SCHEMA, "items": [*lines, *lesions_of(fit)]})


def _plan_on(rig: Rig, plan: Plan, source: FitFolder, goal: FitFolder, other_patient: bool) -> dict[str, Any]:
    """The whole plan on the target: what was made on it as it is, all else carried from the source."""
    if other_patient:
        raise BadDrawing("A plan is one patient's; give a drawing to show it on another one.")
    laid = plan_on_folders(rig, plan, [(goal, ""), (source, "")], home=1)
    shapes = [
        item.model_dump(mode="json")
        for item in items_of(plan, scan_of_plan(plan, source), is_home=True)
        if isinstance(item, PlanLine)
    ]
    missing = {each.item.id for each in laid.missing}
    lines = lines_on_scan({"unit": "mm", "shapes": [each for each in shapes if each["id"] not in missing]}, "mm")
    said = {"doubts": doubts_between(source, goal), "moved": _moved(source, lines)}
    marks = marks_between(source, goal)
    return plan_document(plan, goal, laid) | said | ({"marks": marks} if marks else {})


def _carried_document(
    given: DrawingFile, goal: FitFolder, carried: tuple[TransferredLine, ...], other_patient: bool
) -> dict[str, Any]:
    return {
        "schema": "breastrig/drawing@1",
        "name": given.name,
        "unit": goal.unit,
        "notice": LIMITS_OF_USE,
        **made_on(goal.result),
        "carried_by": "model" if other_patient else "skin",
        "shapes": [
            shape_document(each.line, goal.metres_per_unit)
            | {
                "distance_from_mm": millimetres(each.distance_from),
                "distance_to_mm": millimetres(each.distance_to),
            }
            for each in carried
        ],
    }
