"""Templates in true size, for programs and the command line."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Literal

from breastrig.core.errors import BadInput
from breastrig.core.one_thread import one_thread
from breastrig.core.output_files import all_or_nothing, single_file
from breastrig.core.private_files import write_private
from breastrig.files.result import FIT_FILES, read_result
from breastrig.languages.catalogue import Language
from breastrig.use.folder.earlier_fits import unchecked
from breastrig.use.guides.template import guide_said, guide_stl_of, template_pdf_of
from breastrig.use.report import identity_of, plan_of
from breastrig.use.reports.report import ReportJob
from breastrig.use.transfer import folder_of
from breastrig.use.values.drawing import Drawing
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model, files_of, loaded


def write_template(
    fit: Fit | str | Path,
    file: str | Path,
    other: Fit | str | Path | None = None,
    *,
    plan: Drawing | Mapping[str, Any] | str | Path | None = None,
    side: Literal["", "L", "R"] = "",
    code: str = "",
    same_patient: bool = False,
    language: Language = "en",
    force: bool = False,
    model: Model = None,
    asked_to_stop: Callable[[], None] = lambda: None,
) -> str:
    """Writes a fit's planned lines in true size, laid flat (PDF), or as a guide to print (STL): `breastrig template`.

    Args:
        fit: The fit, or its folder, in whose position the template is laid on the skin.
        file: Where it is written, .pdf or .stl.
        other: Of the same patient in another stance, on which items of the plan were made.
        plan: A drawing in a fit's unit and frame, a document breastrig/plan@1 or drawing@1 or the path of one, in place
            of the fit's own drawing.
        side: Of a guide, the patient's.
        code: The patient's code, never a name; empty: that of the fit.
        same_patient: Whether the plan is this patient's though its file names another.
        language: Of the PDF: en or de.
        force: Replaces the file; never what was read.
        model: Of folders, where it is not the package's; a `Fit` has its own.
        asked_to_stop: Called before the file is put in place; it may raise.

    Returns:
        Of a guide, how far its arrow is from the notch, a sentence; else empty.

    Raises:
        BadInput: With one sentence, of it BadDrawing where the skin is too curved below all lines.
    """
    is_guide = Path(file).suffix.lower() == ".stl"
    if not is_guide and Path(file).suffix.lower() != ".pdf":
        raise BadInput("Give the file a name that ends in .pdf (a template on paper) or .stl (a guide to print in 3D).")
    if is_guide == (side == ""):
        raise BadInput("A guide (.stl) is of one side: say L or R, the patient's. A template (.pdf) has both.")
    document = plan_of(plan)
    with ExitStack() as stack:
        folders = [stack.enter_context(folder_of(each, FIT_FILES)) for each in (fit, other) if each is not None]
        given = [Path(each) / name for each in (fit, other) if isinstance(each, str | Path) for name in FIT_FILES]
        given += [Path(plan)] if isinstance(plan, str | Path) else []
        job = ReportJob(
            folders[0],
            folders[1] if len(folders) > 1 else None,
            plan=document,
            same_patient=same_patient,
            language=language,
            identity=identity_of([read_result(folders[0])], code, document),
            doubts=unchecked(each for each in (fit, other) if isinstance(each, str | Path)),
        )
        output = single_file(Path(file), (*given, *files_of(model)), force, asked_to_stop)
        with one_thread(), all_or_nothing(output) as staging:
            rig = fit.model if isinstance(fit, Fit) else loaded(model)
            content = guide_stl_of(job, side, rig) if is_guide else template_pdf_of(job, rig)
            write_private(staging / Path(file).name, content)
    return guide_said(content) if is_guide else ""
