"""result.json (breastrig/result@1): what a fit says of itself.  One model for all who write, read or serve it.

Lengths named _mm are millimetres; places are in the scan's frame and unit.  What is not said is left out of the file.
Fields that later versions or other programs add are kept.
"""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from datetime import date
from operator import not_
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from breastrig.core.arrays import Array
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput
from breastrig.core.identity import CODE_CHARACTERS, one_line, random_code
from breastrig.core.output_files import OutputSet
from breastrig.core.picks import PLACES
from breastrig.core.private_files import read_ordinary
from breastrig.core.stances import Stance

RESULT = "result.json"
DRAWING = "drawing.json"
UNCERTAINTY = "uncertainty.bin"
CHECKS = "checks.bin"  # of which landmarks a person should check follows (fitting/checks/basis.py)
BODY = "body.bin"  # what the fit says of scales and shapes, for a cohort (fitting/posterior.py)
RESULT_SCHEMA = "breastrig/result@1"
RESULT_BYTES = 4_000_000  # a result.json has some ten thousand
FIT_FILES = (
    "scan.ply",
    "fitted.ply",
    "fitted.glb",
    "drawing.json",
    "distances.bin",
    UNCERTAINTY,
    BODY,
    CHECKS,
    "fit.log.jsonl",
    RESULT,  # the last one: where it stands, the others are there
)
HASHED = ("scan.ply", "fitted.ply", "drawing.json", "distances.bin", UNCERTAINTY, BODY, CHECKS)  # read again
WALL_POINTS = 11_000  # scan/volumes/wall.py has 101 columns to each side
EDITED = 16  # hexadecimal digits of a field's hash: against mistakes, not against intent

Unit = Literal["m", "dm", "cm", "mm", "in", "ft"]
VerdictLevel = Literal["good", "uncalibrated", "check", "unusable"]
Three = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
Four = Annotated[list[FiniteFloat], Field(min_length=4, max_length=4)]
Code = Annotated[str, Field(max_length=CODE_CHARACTERS)]
Digest = Annotated[str, Field(pattern="^[0-9a-f]{16,64}$")]


class Document(BaseModel):
    """A part of it; may hold more than is named here."""

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True, serialize_by_alias=True)


class Distances(Document):
    mean: FiniteFloat | None
    std: FiniteFloat | None
    max: FiniteFloat | None
    p95: FiniteFloat | None


class SurfaceDistances(Distances):
    coverage: FiniteFloat = Field(description="share of the model's vertices with an accepted pair")


class LandmarkDistances(Document):
    mean: FiniteFloat | None
    std: FiniteFloat | None
    max: FiniteFloat | None
    min: FiniteFloat | None
    each: dict[str, FiniteFloat]


class ResultScan(Document):
    vertices: int
    triangles: int = Field(description="of the file, with what was cut away")
    unit: Unit
    unit_reason: str = ""
    sha256: str
    table_triangles: int = Field(default=0, description="of these, cut away as table")
    cut_by_hand_triangles: int | None = Field(
        default=None, description="of these, cut away by a person; absent without any", exclude_if=not_
    )
    reconstructed_from_points: bool = Field(
        default=False, description="the file held points without triangles; absent for others", exclude_if=not_
    )
    cut_away_cm2: int = Field(default=0, description="floors and walls; absent without any", exclude_if=not_)


class ModelSummary(Document):
    name: str
    sha256: str
    vertices: int
    bones: int
    blendshapes: int


class ResultBone(Document):
    name: str
    rotation_xyzw: Four
    translation_m: Three
    scale: Three


class ResultParameters(Document):
    bones: list[ResultBone]
    blendshapes: dict[str, FiniteFloat]


class Verdict(Document):
    level: VerdictLevel
    reasons: tuple[str, ...] = Field(description="one sentence each, the strongest first; of a good fit notes")
    about: tuple[Literal["", "lines", "size"], ...] = Field(
        default=(), description="what each reason is about, in any language; empty in results of versions before"
    )


class DoubtedPick(BaseModel):
    """Picked landmarks that are asked about: not followed, or unusual."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    names: list[str] = Field(description="which ones")
    reason: str = Field(description="one sentence")


class ModelAlone(Document):
    """The distances without the free-form layer: those of the rig as its bones and shapes have it."""

    surface_distance_mm: SurfaceDistances
    scan_to_model_mm: Distances
    landmark_distance_mm: LandmarkDistances


class MedianPlane(Document):
    """Points p with normal · p = offset, in the scan's unit and frame."""

    normal: Three = Field(description="unit vector to the patient's left")
    offset: FiniteFloat


class ResultAreola(Document):
    """An areola in the scan's colours."""

    diameter_mm: FiniteFloat = Field(gt=0.0, lt=300.0, description="of the circle of its area, along the skin")
    within_mm: FiniteFloat = Field(ge=0.0, lt=300.0, description="half of the 90 % band")
    rim: list[Three] = Field(min_length=3, max_length=1000, description="its border, closed")


class ResultLesion(Document):
    """A ball inside the body that the scan's label map shows, in the scan's frame."""

    name: str
    center: Three = Field(description="in the scan's unit")
    radius_mm: FiniteFloat = Field(gt=0.0)


class ResultWall(Document):
    """The chest wall that the scan's label map, or a file drawn on its image, names; in the scan's frame."""

    points: list[Three] = Field(max_length=WALL_POINTS, description="in the scan's unit, some 8 mm apart")
    triangles: list[Annotated[list[int], Field(min_length=3, max_length=3)]] = Field(
        min_length=1, max_length=8 * WALL_POINTS, description="of these, counter-clockwise from the front"
    )

    @model_validator(mode="after")
    def _names_its_points(self) -> "ResultWall":
        if not all(0 <= corner < len(self.points) for each in self.triangles for corner in each):
            raise ValueError("a triangle names a point that is not there")
        return self


class ResultPatient(Document):
    code: Code = ""
    given: bool = Field(default=False, description="by a person; otherwise it is random")
    scanned: date | None = Field(default=None, exclude_if=not_)


class ResultScale(Document):
    """How the scan got its true size; all else of the result is in it."""

    factor: FiniteFloat = Field(gt=0.0, description="from the size of the scan's file to the true one")
    between: Annotated[list[str], Field(min_length=2, max_length=2)] = Field(
        description="two landmarks or marks; `one place` and `another` have no name"
    )
    mm: FiniteFloat = Field(gt=0.0, description="the straight way between them, as measured on the patient")
    measured_mm: FiniteFloat = Field(gt=0.0, description="the same in the scan's file")


class ResultMark(Document):
    """A named place on the skin: on the scan, and which point of the model's skin is there."""

    point: Three = Field(description="as given, in the scan's frame and unit")
    off_scan_mm: FiniteFloat = Field(ge=0.0, description="from there to the scan's surface")
    face: int = Field(ge=0, description="triangle of fitted.ply that is nearest to it")
    barycentric: Three = Field(description="where in that triangle: weights of its three vertices")


def joint_covariance(upper: Sequence[float], landmarks: int) -> Array | None:
    """(3 L, 3 L) of landmark_covariance_mm2; None where there is none, or it is not of so many landmarks."""
    size = 3 * landmarks
    if not size or len(upper) != size * (size + 1) // 2:
        return None
    joint = np.zeros((size, size))
    joint[np.triu_indices(size)] = upper
    return np.asarray(joint + np.triu(joint, 1).T)


class ResultFile(Document):
    """result.json; also the `result` of a done event."""

    schema_: Literal["breastrig/result@1"] = Field(alias="schema")
    notice: str = ""
    scan: ResultScan
    model: ModelSummary
    stance: Stance
    stance_reason: str
    stance_asked: bool = Field(
        False, exclude_if=not_, description="the scan does not show it clearly, and the verdict asks for it"
    )
    predicted: bool = Field(
        default=False,
        exclude_if=not_,
        description="computed from the scan of another stance, of whose fit the distances are; absent in fits",
    )
    preset: str
    refined: bool = Field(description="whether surface, drawing and distances are those of the free-form layer")
    converged: bool
    stop_reason: str
    verdict: Verdict | None = Field(None, description="whether to trust the fit; null in results of versions before")
    iterations: int
    timing_s: dict[str, FiniteFloat]
    surface_distance_mm: SurfaceDistances
    scan_to_model_mm: Distances
    landmark_distance_mm: LandmarkDistances
    model_alone: ModelAlone | None = Field(
        None,
        exclude_if=not_,
        description="without the free-form layer; absent where they are the only ones",
    )
    landmarks_not_followed: list[DoubtedPick] = Field([], description="picks that cannot be right, by name")
    landmarks_unusual: list[DoubtedPick] = Field([], description="picks that were followed and should be looked at")
    not_calibrated: str | None = Field(
        None,
        exclude_if=not_,
        description="why there are no radii, and uncertainty.bin is all nan; null where they are known",
    )
    median_plane: MedianPlane | None = Field(None, description="of the fitted body; null in results of versions before")
    landmark_uncertainty_mm: dict[str, FiniteFloat] = Field(
        {},
        description="radius that holds the landmark's true place with 90 %, by name; of a fit of this version",
    )
    landmark_covariance_mm2: list[FiniteFloat] = Field(
        [],
        exclude_if=not_,
        description="of the errors of the landmarks of landmark_uncertainty_mm together, in their order and the scan's "
        "axes (x, y, z of the first, then of the next): the upper triangle, row by row",
    )
    line_error_mm: FiniteFloat | None = Field(
        None,
        description="line error (90 %) of lines on the breasts, measured across the line; null where it is not known",
    )
    drawn_line_error_mm: FiniteFloat | None = Field(
        None,
        exclude_if=not_,
        description="the largest line error (90 %) of the fit's own drawing, which is then stated first; absent where "
        "nothing is drawn",
    )
    arm_angles_deg: dict[str, FiniteFloat] = Field(
        {},
        exclude_if=not_,
        description="between each upper arm and the trunk, by side (L, R): 0 beside it, 90 at right angles; absent "
        "where the scan hardly shows the arms",
    )
    landmarks_agreed: list[str] = Field([], description="names of those that were proposed and only agreed to")
    landmarks: dict[str, Three] = Field(
        description="of the fitted model, or where the scan's colours show them (landmarks_seen), in the scan's frame "
        "and unit"
    )
    landmarks_seen: dict[str, str] = Field(
        {},
        exclude_if=not_,
        description="the feature that shows each landmark seen in the scan's colours, by name, of those that were "
        "not picked",
    )
    landmarks_picked: dict[str, Three] = Field(description="as given, in the scan's frame and unit")
    scale: ResultScale | None = Field(
        None, exclude_if=not_, description="by which the scan was scaled to its true size; absent where it was not"
    )
    size_known: bool = Field(
        default=True,
        exclude_if=lambda found: found,
        description="false where the scan's file does not say how large the patient is; all errors allow for it",
    )
    marks: dict[str, ResultMark] = Field(
        {}, exclude_if=not_, description="named places on the skin beside the landmarks, by name; absent without any"
    )
    marks_asked: list[DoubtedPick] = Field([], exclude_if=not_, description="marks that lie off the scan's skin")
    areolae: dict[str, ResultAreola | None] = Field(
        {}, exclude_if=not_, description="by side, null where none is seen; absent for a scan without texture"
    )
    lesions: list[ResultLesion] = Field(
        [],
        exclude_if=not_,
        description="shown by the scan's file and by files of lesions fitted with it; those that are added or moved "
        "later are in the plan alone",
    )
    wall: ResultWall | None = Field(
        None, exclude_if=not_, description="the chest wall, where the scan's file names it; else it is estimated"
    )
    parameters: ResultParameters
    drawing_missing: list[str] = Field(
        [],
        exclude_if=not_,
        description="why a pattern that was asked for is not in the drawing, a sentence or two for each",
    )
    notes: list[str]
    versions: dict[str, str]
    patient: ResultPatient | None = Field(
        default=None, exclude_if=not_, description="whose scan it is; absent in the service"
    )
    files: dict[str, Digest] = Field(
        {},
        exclude_if=not_,
        description="sha256 of each file beside this one that is read again; absent in results of versions before",
    )
    fields: dict[str, Digest] = Field(
        {}, exclude_if=not_, description="first digits of the sha256 of each field of the file; absent in answers"
    )

    @property
    def distances(self) -> "ResultFile | ModelAlone":
        """The distances of the model alone where they are known."""
        return self if self.model_alone is None else self.model_alone

    def without_marks(self) -> "ResultFile":
        """For others to see: without marks, and with no name of one, which people call what they like."""
        found = self.model_copy(update={"marks": {}, "marks_asked": []})
        if self.scale is None:
            return found
        ends = list(zip(self.scale.between, PLACES, strict=True))
        said = [name if name in self.landmarks else place for name, place in ends]
        between = " to ".join(self.scale.between), " to ".join(said)
        notes = [each.replace(*between) if each.startswith("Scaled by ") else each for each in self.notes]
        return found.model_copy(update={"scale": self.scale.model_copy(update={"between": said}), "notes": notes})

    def document(self) -> dict[str, Any]:
        """The JSON document."""
        return self.model_dump(mode="json")

    def content(self) -> bytes:
        """The file, with the hash of each field where the hashes of the files beside it are known."""
        document = self.document()
        document.pop("fields", None)
        if not self.files:
            return json_bytes(document)
        return json_bytes(document | {"fields": _field_hashes(json_bytes(document))})

    def beside(self, files: Mapping[str, bytes]) -> "ResultFile":
        """The result with the hashes of these files."""
        return self.model_copy(update={"files": {name: _sha256(files[name]) for name in HASHED}})

    def check_files(self, read: Callable[[str], bytes | None], shown: str) -> None:
        """Raises BadInput where a file is not the one that the fit wrote; `read` returns None for a missing file.

        Passes for results of versions that stored no hashes; a missing file is reported where it is needed.
        """
        for name in HASHED:
            content = read(name) if name in self.files else None
            if content is not None and _sha256(content) != self.files[name]:
                own = "give lines of your own with --drawing or --plan" if name == "drawing.json" else "fit again"
                raise BadInput(
                    f"{shown}/{name} is not the file that this fit wrote: it was exchanged or changed since. "
                    f"Put the fit's own file back, or {own}."
                )


def fit_set(folder: Path) -> OutputSet:
    """The files of a fit, in a folder of an output's."""
    return OutputSet(folder, FIT_FILES, RESULT, RESULT_SCHEMA)


def parsed_result(text: bytes, shown: str) -> ResultFile:
    """The result; BadInput where it is damaged or was changed since it was written. `shown` names the folder."""
    try:
        result = ResultFile.model_validate_json(text)
    except ValidationError as error:
        where = ".".join(map(str, error.errors(include_url=False, include_input=False)[0]["loc"]))
        raise damaged(shown, where or "it is no result of a fit") from error
    changed = _changed_fields(text, result.fields)
    if changed:
        raise BadInput(
            f"{shown}/{RESULT} was changed since it was written ({', '.join(changed[:5])}). Put the fit's own file "
            "back, or fit again: stance, unit and code are options of `breastrig fit`."
        )
    return result


def _changed_fields(text: bytes, hashes: Mapping[str, str]) -> list[str]:
    """Names of fields that are not as they were written; of those that were not written, only what is known here."""
    if not hashes:
        return []
    found = _field_hashes(text)
    names = hashes.keys() | {name for name in found if name == "schema" or name in ResultFile.model_fields}
    return sorted(name for name in names if found.get(name) != hashes.get(name))


def _field_hashes(text: bytes) -> dict[str, str]:
    """Hashes of the document's fields, equal for 5 and 5.0, 0 and -0, and any spacing (programs may rewrite it)."""

    def number(text: str) -> float:
        return float(text) + 0.0  # no negative zero

    document = json.loads(text, parse_int=number, parse_float=number)
    document.pop("fields", None)
    return {name: _sha256(json.dumps(value, sort_keys=True).encode())[:EDITED] for name, value in document.items()}


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def damaged(shown: str, where: str) -> BadInput:
    return BadInput(f"{shown}/{RESULT} is damaged or of another version ({where}); fit the scan again.")


def result_text(folder: Path) -> bytes:
    """The bytes of the folder's result.json, none when it is far too large to be one; BadInput when it has none."""
    try:
        text = read_ordinary(folder / RESULT, RESULT_BYTES)
    except OSError as error:
        raise BadInput(f"There is no fit in {folder.name[:100]}; give a folder that `breastrig fit` wrote.") from error
    return text if len(text) <= RESULT_BYTES else b""


def read_result(folder: Path) -> ResultFile:
    """The result in a fit's folder; BadInput where there is none."""
    return parsed_result(result_text(folder), folder_name(folder))


def folder_name(folder: Path) -> str:
    """A folder's name for messages, without its location."""
    return folder.resolve().name[:100]


def patient_of(code: str, scanned: date | None) -> ResultPatient:
    """The patient under this code, or a random one where it is empty; BadInput for invisible characters."""
    given = one_line(code)[:CODE_CHARACTERS]
    return ResultPatient(code=given or random_code(), given=bool(given), scanned=scanned)
