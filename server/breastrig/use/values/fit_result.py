"""A finished fit as programs hold it, save it and load it.

A `Fit` says what its files say: whether it was just made or loaded, measures and transfers of it agree with those of
the command line to the digits that files have.  Its files are made when asked for, and can be saved anywhere.
"""

import json
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from breastrig.core.arrays import Array, Integers, frozen
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadDrawing, BadInput
from breastrig.core.one_thread import one_thread
from breastrig.core.output_files import Output as FolderOutput
from breastrig.core.output_files import all_or_nothing
from breastrig.core.private_files import write_files
from breastrig.files.result import (
    DRAWING,
    FIT_FILES,
    RESULT,
    UNCERTAINTY,
    ResultFile,
    ResultPatient,
    damaged,
    fit_set,
    folder_name,
)
from breastrig.fitting.verdicts.verdict import Verdict
from breastrig.report.bands import lines_text
from breastrig.rig.modes import mode_count
from breastrig.rig.named_parameters import Parameters, parameters_by_name
from breastrig.scan.clean import Surface
from breastrig.use.folder.fit_files import fit_file, result_of
from breastrig.use.folder.fit_folder import FitFolder, fit_of_files, fitted, read_fit_files
from breastrig.use.steps.outcome import FitOutcome
from breastrig.use.values.drawing import Drawing, Lesion, Line, document_of, drawing_of
from breastrig.use.values.frame import Frame, frame_of
from breastrig.use.values.model import Model, Rig, loaded, public
from breastrig.use.values.posterior import Posterior, posterior_of

if TYPE_CHECKING:
    import trimesh
    from PIL.Image import Image

    from breastrig.use.lines.line_checks import LineChecks


class FitFiles:
    """The contents of a fit's files by name: read from a folder, or made of an outcome when first asked for."""

    def __init__(
        self, made: dict[str, bytes], outcome: FitOutcome | None = None, result: ResultFile | None = None
    ) -> None:
        """`result` is what the outcome says of itself."""
        self._made, self._outcome, self._result = made, outcome, result

    def __getitem__(self, name: str) -> bytes:
        if name not in self._made:
            if self._outcome is None or self._result is None:
                raise BadInput(f"{name} was not in the folder that this fit was read from; fit the scan again.")
            with one_thread():
                made = self._result.content() if name == RESULT else fit_file(self._outcome, name)
            self._made[name] = made
        return self._made[name]

    def several(self, names: Sequence[str], patient: ResultPatient | None = None) -> dict[str, bytes]:
        """The files of these names, in that order; BadInput names the one that is missing."""
        is_whole = self._result is not None and set(names) >= set(FIT_FILES)
        files = {name: b"" if is_whole and name == RESULT else self[name] for name in names}
        if self._result is not None and is_whole:
            if patient is not None:  # the drawing says whose it is, too
                files[DRAWING] = json_bytes(json.loads(files[DRAWING]) | {"patient": patient.code})
            files[RESULT] = self._result.model_copy(update={"patient": patient}).beside(files).content()
        return files

    def __reduce__(self) -> tuple[type["FitFiles"], tuple[dict[str, bytes]]]:
        """Between processes go the files, not what they were made of."""
        return FitFiles, (self.several(FIT_FILES) if self._outcome is not None else self._made,)


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """The model fitted to one scan: V model vertices, F model triangles, S vertices and G triangles of the scan.

    Everything is in the scan's unit and frame; arrays cannot be written to.  A Fit is what one fit found: its values
    come from `in_metres` and cannot be given anew (`dataclasses.replace` raises ValueError), so that measures, files
    and values agree.  `fit.model.pose` makes other bodies.
    """

    model: Rig = field(init=False)
    unit: str = field(init=False)  # the scan's: m, dm, cm, mm, in or ft
    metres_per_unit: float = field(init=False)
    # (V, 3) the whole fitted model, unseen parts included, in the template's vertex order
    vertices: Array = field(init=False)
    faces: Integers = field(init=False)  # (F, 3)
    scan_vertices: Array = field(init=False)  # (S, 3) the scan as it was fitted: cleaned, without a table
    scan_faces: Integers = field(init=False)  # (G, 3)
    # (3,) each: where the fitted model has them, those of `seen` where colours show them
    landmarks: dict[str, Array] = field(init=False)
    # landmarks that the scan's colours show, each with what shows it; of those that were not picked
    seen: dict[str, str] = field(init=False)
    picked: dict[str, Array] = field(init=False)  # (3,) each: as they were given
    not_followed: dict[str, str] = field(init=False)  # given landmarks that all else contradicts, each with a sentence
    marks: dict[str, Array] = field(init=False)  # (3,) each, of any names: as they were given
    # given landmarks that were followed and should be looked at, each with a sentence
    unusual: dict[str, str] = field(init=False)
    # pose, shape and the layer over them: `model.pose(parameters)` is `vertices`
    parameters: Parameters = field(init=False)
    stance: str = field(init=False)  # standing | supine | prone
    verdict: Verdict = field(init=False)  # level (good | uncalibrated | check | unusable) and reasons
    converged: bool = field(init=False)
    stop_reason: str = field(init=False)
    iterations: int = field(init=False)
    # why a pattern that was asked for is not in the drawing, a text each
    drawing_missing: tuple[str, ...] = field(init=False)
    notes: tuple[str, ...] = field(init=False)  # what reading and cleaning the scan found, one sentence each
    files: FitFiles
    in_metres: FitFolder  # what measures and transfers work on
    inputs: tuple[Path, ...] = ()  # files that the fit was made from; saving replaces none of them
    known_posterior: Posterior | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for name, value in _public_values(self.in_metres).items():
            object.__setattr__(self, name, value)

    @cached_property
    def result(self) -> dict[str, Any]:
        """The document of result.json."""
        return self.in_metres.result.document()

    @cached_property
    def distances(self) -> Array:
        """(V,) from each model vertex to the scan, in the scan's unit.

        Above zero where the model lies outside the scan's skin; nan where the scan shows nothing.
        """
        return self._of_vertices("distances.bin")

    @cached_property
    def uncertainty(self) -> Array:
        """(V,) the radius around each of `vertices` that holds its true place with 90 %, in the scan's unit.

        All nan where nobody has calibrated the model, which `result["not_calibrated"]` says.
        """
        return self._of_vertices(UNCERTAINTY)

    def _of_vertices(self, name: str) -> Array:
        """(V,) in the scan's unit, from a file of millimetres."""
        found = np.frombuffer(self.files[name], dtype="<f4").astype(np.float64)
        if len(found) != len(self.vertices):
            raise BadInput(f"{name} does not belong to this fit; fit the scan again.")
        return np.asarray(frozen(1e-3 * found / self.metres_per_unit))

    @property
    def line_error_mm(self) -> float | None:
        """Line error (90 %, mm) of lines on the breasts; None where it is not known."""
        return self.in_metres.result.line_error_mm

    @property
    def drawn_line_error_mm(self) -> float | None:
        """The largest line error (90 %, mm) of the fit's own lines; None where nothing is drawn."""
        return self.in_metres.result.drawn_line_error_mm

    @cached_property
    def landmark_radii(self) -> dict[str, float]:
        """The radius around each of `landmarks` that holds its true place with 90 %, in the scan's unit.

        Empty where nobody has calibrated the model.
        """
        radii = self.in_metres.result.landmark_uncertainty_mm
        return {name: 1e-3 * mm / self.metres_per_unit for name, mm in radii.items()}

    @cached_property
    def frame(self) -> Frame:
        """The directions left, up and front of this body."""
        return frame_of(self.in_metres.rig, self.in_metres.vertices, self.metres_per_unit)

    def picture(
        self,
        view: str = "front",
        *,
        show: Literal["distances", "uncertainty", "model", "scan"] = "distances",
        drawing: Drawing | None = None,
        size: tuple[int, int] = (480, 560),
    ) -> "Image":
        """A picture of `size` (width, height) pixels, without a display.

        Args:
            view: front, left, right, back, three_quarter, three_quarter_right, top or below.
            show: distances (the model, blue inside the scan's skin and orange outside, grey where the scan shows
                nothing), uncertainty (the model, darker where its 90 % radius is larger, to 20 mm), or the bare
                model or scan.
            drawing: Lines and lesions on it, in this fit's unit and frame.
            size: Width and height in pixels.

        Raises:
            BadSettings: For another view.
        """
        from breastrig.use.values.picture import fit_picture  # rendering, which other programs need not load

        return fit_picture(self.in_metres, view, show, () if drawing is None else drawing.lines, size)

    @property
    def posterior(self) -> Posterior:
        """The posterior of pose and shape. Raises BadInput for a loaded fit without a usable checks.bin."""
        if self.known_posterior is not None:
            return self.known_posterior
        found = self.in_metres
        if found.checks is None:
            raise BadInput("The posterior is in no file of this fit; fit the scan again to have it.")
        return posterior_of(found.rig, found.parameters, found.checks.covariance)

    @cached_property
    def drawing(self) -> Drawing:
        """The drawing on the scan's skin, in its unit and frame; no lines where none was asked for."""
        try:
            document = json.loads(self.files["drawing.json"])
        except (ValueError, RecursionError) as error:
            raise BadDrawing("drawing.json of this fit is damaged; fit the scan again.") from error
        return drawing_of(document, self.inputs)

    def checks(self, drawing: Drawing | Sequence[Line] | None = None) -> "LineChecks":
        """The landmarks that a person should look at to make lines surer, by the fit's posterior.

        Args:
            drawing: Lines on this scan, in its unit and frame, drawn on it or transferred to it; None: the fit's own
                drawing. Where there are none, lines count that would lie on the breasts.

        Raises:
            BadDrawing: For lines that are not on a scan.
        """
        from breastrig.drawings.drawing_file import lines_on_scan
        from breastrig.use.lines.line_checks import line_checks  # skin maps and plans, as for lesions

        shown = self.drawing if drawing is None else drawing
        lines, document = (shown.lines, shown.document) if isinstance(shown, Drawing) else (shown, document_of(shown))
        carried = [line.distance_from_mm is not None for line in lines if len(line.points)]
        with one_thread():
            return line_checks(self.in_metres, lines_on_scan(document, self.unit), carried)

    @cached_property
    def lesions(self) -> tuple[Lesion, ...]:
        """The lesions of the label map that was fitted, with depth and distances; `transfer` takes them."""
        from breastrig.use.lines.plan_on_fit import lesions_document

        with one_thread():
            return drawing_of(lesions_document(self.in_metres)).lesions

    def to_trimesh(self) -> "trimesh.Trimesh":
        """A copy of the fitted model as a trimesh.Trimesh, in the scan's unit and frame, vertices in their order."""
        import trimesh  # 0.4 s, which most programs need not wait for

        return trimesh.Trimesh(self.vertices, self.faces, process=False)

    def save(self, folder: str | Path, *, force: bool = False) -> None:
        """Writes the files of `breastrig fit -o FOLDER`, all of them or none, for their owner only.

        result.json, scan.ply, fitted.ply, fitted.glb, drawing.json, distances.bin, uncertainty.bin, body.bin,
        checks.bin and fit.log.jsonl; each says its unit or has the scan's.  Replaces an earlier fit's files; others
        with `force` only, and files that the fit was made from never.  Raises BadInput.
        """
        output = FolderOutput(Path(folder), (fit_set(Path()),), self.inputs, force)
        with all_or_nothing(output) as staging:
            self.write(staging)

    def write(self, folder: Path, patient: ResultPatient | None = None) -> None:
        """Writes the files into a folder that is the caller's to protect.  Raises BadInput."""
        write_files(self.files.several(FIT_FILES, patient), folder)

    @staticmethod
    def load(folder: str | Path, model: Model = None) -> "Fit":
        """The fit that `save`, `breastrig fit` or `breastrig batch` wrote; `model` is the one it was made with.

        result.json, scan.ply and fitted.ply must be there; another file is reported missing when it is requested.
        Places are in the scan's unit and frame. Raises BadInput with one sentence.
        """
        place = Path(folder)
        contents, shown = read_fit_files(place), folder_name(place)
        found = fit_of_files(contents, loaded(model), shown)
        if found.result.verdict is None:
            raise damaged(shown, "verdict")
        files = FitFiles(contents | {RESULT: found.result.content()})
        return Fit(files=files, in_metres=found)

    def _repr_html_(self) -> str:
        """A picture from the front for notebooks, the model coloured by its distance to the scan, with the verdict."""
        stream = BytesIO()
        self.picture(size=(300, 360)).save(stream, "PNG")
        image = b64encode(stream.getvalue()).decode("ascii")
        said = escape(f"{repr(self)[1:-1]}. {' '.join(self.verdict.reasons)}")
        return f'<figure><img alt="fitted model" src="data:image/png;base64,{image}"><p>{said}</p></figure>'

    def __repr__(self) -> str:
        mean = self.in_metres.result.surface_distance_mm.mean
        far = "no pair" if mean is None else f"{mean:.2f} mm to the scan"
        sure = lines_text(self.line_error_mm, self.drawn_line_error_mm)
        good = f"{self.verdict.level}{sure and f': {sure}'}"
        return f"<Fit: {self.stance}, {good}; {far}, {self.iterations} iterations, in {self.unit}>"


def fit_of_outcome(outcome: FitOutcome, inputs: tuple[Path, ...]) -> Fit:
    """The Fit of a fit that has just ended."""
    target, radii, rig = outcome.ready.prepared.target, outcome.radii, outcome.ready.plan.rig
    with one_thread():
        result = result_of(outcome)
        found = fitted(
            rig,
            result,
            Surface(target.vertices, target.faces, ()),
            outcome.vertices,
            outcome.parameters,
            None if radii is None else radii.vertices,
            outcome.checks,
        )
        files = FitFiles({}, outcome, result)
        posterior = posterior_of(rig, outcome.parameters, outcome.covariance)
        return Fit(files=files, in_metres=found, inputs=inputs, known_posterior=posterior)


def _public_values(found: FitFolder) -> dict[str, Any]:
    """The values of a Fit's fields by name, in the scan's unit."""
    result, per_unit = found.result, found.metres_per_unit
    if result.verdict is None:
        raise damaged("this fit", "verdict")
    return {
        "model": public(found.rig),
        "unit": found.unit,
        "metres_per_unit": per_unit,
        "vertices": frozen(found.vertices / per_unit),
        "faces": found.rig.faces,
        "scan_vertices": frozen(found.surface.vertices / per_unit),
        "scan_faces": frozen(found.surface.faces, np.int64),
        "landmarks": {name: frozen(place) for name, place in result.landmarks.items()},
        "seen": dict(result.landmarks_seen),
        "picked": {name: frozen(place) for name, place in result.landmarks_picked.items()},
        "marks": {name: frozen(mark.point) for name, mark in result.marks.items()},
        "not_followed": {name: each.reason for each in result.landmarks_not_followed for name in each.names},
        "unusual": {name: each.reason for each in result.landmarks_unusual for name in each.names},
        "parameters": parameters_by_name(
            found.rig, found.parameters, per_unit, found.vertices if result.refined or mode_count(found.rig) else None
        ),
        "stance": found.stance,
        "verdict": Verdict(result.verdict.level, tuple(result.verdict.reasons)),
        "converged": result.converged,
        "stop_reason": result.stop_reason,
        "iterations": result.iterations,
        "drawing_missing": tuple(result.drawing_missing),
        "notes": tuple(result.notes),
    }
