"""A drawing of one scan on another, for programs: of fits in memory or in folders."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadInput
from breastrig.core.one_thread import one_thread
from breastrig.core.private_files import write_files
from breastrig.core.scratch import scratch_folder
from breastrig.drawings.plan_schema import PLAN_SCHEMA
from breastrig.files.result import BODY, FIT_FILES, RESULT, UNCERTAINTY
from breastrig.rig.model import Rig
from breastrig.use.draw import Drawn, items_of
from breastrig.use.lines.transfer_lines import TransferJob, drawing_document, transfer_with
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
            job = TransferJob(folders[0], folders[1], document, other_patient, None, same_patient, same_patient)
            found = transfer_with(rig, job)
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
    return {"schema": PLAN_SCHEMA, "items": items_of(given, fit)}, inputs


@contextmanager
def folder_of(fit: Fit | str | Path, names: Sequence[str]) -> Iterator[Path]:
    """A folder with these files of the fit; for the moment, where it has none."""
    if not isinstance(fit, Fit):
        yield Path(fit)
        return
    with scratch_folder() as folder:
        write_files(fit.files.several(names), folder)
        yield folder
