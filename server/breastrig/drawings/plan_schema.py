"""The plan (breastrig/plan@1): everything that the surgeon wants on the skin of one patient, in one document.

Each item has an id that stays when it is renamed, moved or carried, and says on which scan it was made.  Lines are
kept as they were drawn; patterns and tumours as what was asked for, so that they can be changed; what they look like
on a scan is computed (plan_on_scan.py).  A drawing file is a plan too: its lines become items.
"""

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from operator import not_
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import Field, FiniteFloat, ValidationError, model_validator

from breastrig.core.errors import BadDrawing
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.stances import Stance
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.drawing_schema import SCHEMA, DrawnShape, GivenDrawing, Part, PatientCode, Point, Title
from breastrig.scan.true_size import IN_SIZE, Scale

PLAN_SCHEMA: Literal["breastrig/plan@1"] = "breastrig/plan@1"
ITEMS, POINTS = 500, 50_000  # in one plan; points of all its lines together, as in a drawing
TEXT = 2_000  # characters of a note: a paragraph, not a record
INKS = 500  # as many shapes as a scan's ink may have
DEEPEST = 150.0  # mm; a breast is not thicker

Named = TypeVar("Named", bound=Hashable)
ItemId = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
ScanId = Annotated[str, Field(max_length=64)]
Typed = Annotated[str, Field(max_length=200)]
Word = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,63}$")]


def empty_plan_on_scan(unit: str) -> dict[str, Any]:
    """breastrig/drawing@1 of a plan without items, on a scan of this unit."""
    nothing: dict[str, Any] = {"shapes": [], "lesions": [], "notes": [], "missing": []}
    return {"schema": SCHEMA, "name": "plan", "unit": unit, "notice": LIMITS_OF_USE} | nothing


def _is_empty(values: list[str]) -> bool:
    return not values


class _Item(Part):
    id: ItemId = Field(description="stays the same through all changes; unique in the plan")
    scan: ScanId = Field("", description="of the scan that it was made on; empty: the one that is at hand")


class PlanLine(DrawnShape, _Item):
    """A line that was drawn on the scan's skin, mm."""

    kind: Literal["line"] = "line"
    ink: list[Title] = Field(
        default=[],
        max_length=INKS,
        description="names of the shapes of the scan's ink that it was made from, also when it was changed since",
        exclude_if=_is_empty,
    )
    mirrored: bool = Field(
        False,
        exclude_if=not_,
        description="not drawn by hand: the line of the other side, mirrored, however it was changed since",
    )
    depth_mm: float | None = Field(
        None, ge=1.0, le=DEEPEST, exclude_if=not_, description="how deep it is to be cut; null where nobody has said"
    )


class PlanPattern(_Item):
    """One of the model's own drawings, or a pattern with its parameters."""

    kind: Literal["pattern"] = "pattern"
    name: Word = Field(description="of the drawing or pattern, for instance lumpectomy or reduction")
    parameters: dict[Word, FiniteFloat | Annotated[str, Field(pattern=r"^[A-Za-z]{1,20}$")]] = Field(
        default={}, max_length=20, description="values that differ from the pattern's defaults"
    )


class PlanTumour(_Item):
    """A tumour by the clock of the breast."""

    kind: Literal["tumour"] = "tumour"
    side: Literal["L", "R"] = Field(description="the patient's side")
    clock: float = Field(gt=0.0, lt=13.0, description="hour as read by an observer facing the patient")
    distance_mm: float = Field(ge=0.0, le=200.0, description="from the nipple along the skin")
    radius_mm: float = Field(ge=1.0, le=80.0, description="of the circle along the skin, margin included")
    depth_mm: float | None = Field(None, ge=0.0, le=DEEPEST, description="below the skin; null where it is not known")


class PlanLesion(_Item):
    """A ball inside the body, mm: what an image showed."""

    kind: Literal["lesion"] = "lesion"
    name: Title
    center: Point = Field(description="in the frame of the scan that it was seen with, inside the body")
    radius_mm: float = Field(ge=0.5, le=80.0, description="without margin")
    radiology: Typed = Field(default="", exclude_if=not_, description="what radiology wrote of its place, as typed")


class PlanNote(_Item):
    """A sentence, of the whole or of one place, mm."""

    kind: Literal["note"] = "note"
    text: str = Field(min_length=1, max_length=TEXT)
    point: Point | None = None


PlanItem = Annotated[PlanLine | PlanPattern | PlanTumour | PlanLesion | PlanNote, Field(discriminator="kind")]


class ScanOfPlan(Part):
    """One of the scans that items name."""

    id: ScanId
    stance: Stance | None = None
    sha256: str | None = Field(None, max_length=64, description="of the scan that was fitted, as result.json has it")
    scale: Scale | None = Field(None, exclude_if=lambda found: found is None, description=IN_SIZE)


class Plan(Part):
    """All items of one patient, in the order in which they were made; points are mm in their own scan's frame."""

    schema_: Literal["breastrig/plan@1"] = Field(default=PLAN_SCHEMA, alias="schema")
    unit: Literal["mm"] = "mm"
    patient: PatientCode | None = Field(default=None, description="the patient's code; another's plan is asked about")
    scans: list[ScanOfPlan] = Field(default=[], max_length=20, description="that the items name")
    items: list[PlanItem] = Field(max_length=ITEMS)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        points = sum(len(item.points) for item in self.items if isinstance(item, PlanLine))
        if points > POINTS:
            raise BadDrawing(f"This plan has {points} points; at most {POINTS} can be kept.")
        twice = _twice([item.id for item in self.items])
        if twice is not None:
            raise BadDrawing(f'Two items of this plan have the id "{twice}"; give each one of its own.')
        name = _twice([(item.scan, item.name) for item in self.items if isinstance(item, PlanLine)])
        if name is not None:
            raise BadDrawing(f'Two lines of one scan are called "{name[1]}"; give each a name of its own.')
        return self

    def of_scan(self, scan: str) -> tuple["PlanItem", ...]:
        """The items that were made on that scan."""
        return tuple(item for item in self.items if item.scan == scan)


def _twice(values: Sequence[Named]) -> Named | None:
    return next((value for value, count in Counter(values).items() if count > 1), None)


def is_plan(document: dict[str, Any]) -> bool:
    """Whether a document is marked as a plan, and not as a drawing."""
    return document.get("schema") == PLAN_SCHEMA


def checked_plan(document: dict[str, Any], unit: str = "mm") -> Plan:
    """The plan of a document, also of a drawing file whose lines lie on a scan; in `unit` where that names none.

    Raises BadDrawing with a sentence.
    """
    try:
        if is_plan(document):
            return Plan.model_validate(document)
        drawing = GivenDrawing.model_validate(document)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise BadDrawing(f"This is no plan of the form breastrig/plan@1 ({where}: {first['msg']}).") from error
    except RecursionError as error:
        raise BadDrawing("This plan is nested too deeply; give a file that BreastRig has written.") from error
    elsewhere = next((shape.name for shape in drawing.shapes if not shape.points), None)
    if elsewhere is not None:
        raise BadDrawing("A drawing becomes a plan where its points lie on a scan; give a plan or such a file.")
    to_mm = 1e3 * METRES_PER_UNIT[drawing.unit or unit]
    return Plan(
        schema=PLAN_SCHEMA,
        patient=drawing.patient,
        items=[
            _in_mm(line_item(shape.model_dump(), f"line-{k}", ""), to_mm) for k, shape in enumerate(drawing.shapes, 1)
        ],
    )


def _in_mm(line: PlanLine, to_mm: float) -> PlanLine:
    if to_mm == 1.0:
        return line
    points = [[round(to_mm * value, 3) for value in point] for point in line.points]
    return PlanLine.model_validate(line.model_dump() | {"points": points})


def line_item(shape: dict[str, Any], item_id: str, scan: str) -> PlanLine:
    """A shape of a drawing file as an item."""
    fields = ("name", "label", "closed", "color", "points", "bridged", "error_mm", "mirrored")
    return PlanLine.model_validate({key: shape[key] for key in fields if key in shape} | {"id": item_id, "scan": scan})


def asked_of(item: PlanPattern | PlanTumour) -> tuple[str, Mapping[str, float | str]]:
    """Name and parameters of an item's drawing, as patterns.py takes them."""
    if isinstance(item, PlanTumour):
        return "tumour", item.model_dump(include={"side", "clock", "distance_mm", "radius_mm"})
    return item.name, item.parameters
