"""Everything that can be drawn on a fitted model: its own drawings, and patterns made from millimetres.

A drawing is asked for by a text, in a command, a job or a request:

    lumpectomy
    reduction:areola_mm=42,limb_mm=55
    reduction:areola_mm=42,limb_mm_left=45   (of one side alone: _left or _right)
    lumpectomy+tumour:side=L,clock=10,distance_mm=45,radius_mm=12
    lumpectomy+tumour:L,10,45,12             (where all parameters are needed, their names may be left out)

A drawing of the model is a file (fixed surface points); a pattern is a class that knows its parameters and draws
itself on this patient's skin.  The text is checked before a fit begins, the pattern is built when it has ended.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from pydantic import BaseModel, ValidationError

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing, unknown_name
from breastrig.core.stances import SIDES, sides_of, split_side
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.constructions.apart import Apart, are_apart, of_side, parted
from breastrig.drawings.constructions.ellipse import MastectomyEllipse
from breastrig.drawings.constructions.periareolar import Periareolar
from breastrig.drawings.constructions.reduction import Reduction
from breastrig.drawings.constructions.tumour import PickedTumour, Tumour
from breastrig.drawings.constructions.vertical import Vertical
from breastrig.drawings.constructions.written_numbers import split_parameters
from breastrig.rig.model import DrawnShape, ModelDrawing, Rig


class Pattern(Protocol):
    """A pattern's parameters, with the method that draws it."""

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """The lines on one patient's fitted skin; BadDrawing when they do not fit there."""


PATTERNS: dict[str, type[BaseModel]] = {
    "reduction": Reduction,
    "vertical": Vertical,
    "periareolar": Periareolar,
    "ellipse": MastectomyEllipse,
    "tumour": Tumour,
    "tumour_at": PickedTumour,
}
LABELS = {
    "reduction": "Reduction (Wise pattern)",
    "vertical": "Reduction (vertical pattern)",
    "periareolar": "Lift or reduction around the areola",
    "ellipse": "Mastectomy (ellipse)",
    "tumour": "Tumour",
    "tumour_at": "Tumour",
}
NEEDED_MARKS: dict[str, set[str]] = {  # landmarks of each side
    "reduction": {"nipple", "midclavicle", "inframammary_fold"},
    "vertical": {"nipple", "midclavicle", "inframammary_fold"},
    "periareolar": {"nipple"},
    "ellipse": {"nipple"},
    "tumour": {"nipple"},
    "tumour_at": set(),
}
FIXED = 'The drawing "{}" is a fixed one of the model and has no parameters.'
POINT = " (decimals with a point)"  # where commas stand between numbers


@dataclass(frozen=True, eq=False)
class AskedDrawing:
    """A checked request, not yet drawn."""

    fixed: tuple[ModelDrawing, ...]
    patterns: tuple[tuple[str, Pattern], ...]

    def on_model(self, rig: Rig, vertices: Array, landmarks: Mapping[str, Array] | None = None) -> ModelDrawing:
        """The drawing as surface points, for (V, 3) m fitted vertices in the scan's frame.

        `landmarks` (3,) m are those that are known better than by the model.
        """
        if len(self.fixed) == 1 and not self.patterns:
            return self.fixed[0]  # the rig's own, of which more is known already
        return self.on_skin(FittedSkin(rig, vertices, landmarks or {}))

    def where_it_fits(
        self, rig: Rig, vertices: Array, landmarks: Mapping[str, Array]
    ) -> tuple[ModelDrawing | None, tuple[str, ...]]:
        """The drawing as by `on_model`, without patterns that do not fit this patient; a sentence for each of these."""
        try:
            return self.on_model(rig, vertices, landmarks), ()
        except BadDrawing:
            skin, fitting, missing = FittedSkin(rig, vertices, landmarks), [], []
        for name, pattern in self.patterns:
            try:
                pattern.drawn(skin)
                fitting.append((name, pattern))
            except BadDrawing as error:
                missing.append(f"Not drawn: {LABELS[name]}. {error}")
        left = replace(self, patterns=tuple(fitting))
        return left.on_skin(skin) if left.fixed or left.patterns else None, tuple(missing)

    def on_skin(self, skin: FittedSkin) -> ModelDrawing:
        """The drawing on a skin that caches its measurements."""
        shapes = [shape for drawing in self.fixed for shape in drawing.shapes]
        shapes += [shape for _, pattern in self.patterns for shape in pattern.drawn(skin)]
        names = [drawing.name for drawing in self.fixed] + [name for name, _ in self.patterns]
        labels = [drawing.label for drawing in self.fixed] + [LABELS[name] for name, _ in self.patterns]
        return ModelDrawing("_and_".join(dict.fromkeys(names)), ", ".join(dict.fromkeys(labels)), _unique(shapes))


def known_drawings(rig: Rig) -> tuple[str, ...]:
    """Names that `asked_drawing` takes; a file of the model goes before a pattern of the same name."""
    return (*rig.drawing_names, *(name for name in PATTERNS if name not in rig.drawing_names))


def able_patterns(rig: Rig) -> tuple[str, ...]:
    """Names of the patterns for which this rig has the landmarks and lines."""
    lines = {shape.name for drawing in rig.drawings for shape in drawing.shapes}
    able = {name for name, marks in NEEDED_MARKS.items() if rig.has_landmarks(marks)}
    if not {"inframammary_fold_L", "inframammary_fold_R"} <= lines:
        able.discard("reduction")
    return tuple(name for name in PATTERNS if name in able and name not in rig.drawing_names)


def offered_patterns(rig: Rig) -> tuple[tuple[str, str], ...]:
    """(name, label) of the patterns that this rig can show without further parameters."""
    able = able_patterns(rig)
    return tuple(
        (name, LABELS[name])
        for name in able
        if not any(field.is_required() for field in PATTERNS[name].model_fields.values())
    )


def asked_drawing(rig: Rig, text: str) -> AskedDrawing:
    """The checked request; BadDrawing says which word or number is wrong."""
    parts = []
    for part in text.split("+"):
        name, colon, values = (word.strip() for word in part.partition(":"))
        if colon and name in rig.drawing_names:
            raise BadDrawing(FIXED.format(name))
        parts.append(drawing_with(rig, name, _parameters(name, values) if name in PATTERNS else {}))
    fixed, patterns = ([one for each in parts for one in each.fixed], [one for each in parts for one in each.patterns])
    return AskedDrawing(tuple(fixed), tuple(patterns))


def drawing_with(rig: Rig, name: str, given: Mapping[str, float | str]) -> AskedDrawing:
    """The model's drawing or the pattern of this name, checked; BadDrawing says which word or number is wrong."""
    for drawing in rig.drawings:
        if drawing.name == name:
            if given:
                raise BadDrawing(FIXED.format(name))
            return AskedDrawing((drawing,), ())
    if name not in PATTERNS:
        raise BadDrawing(unknown_name("drawing of this model", name, known_drawings(rig)))
    return AskedDrawing((), ((name, pattern_of(name, given)),))


def pattern_of(name: str, given: Mapping[str, float | str]) -> Pattern:
    """The pattern of this name with these parameters; BadDrawing says which of them is wrong."""
    if name not in PATTERNS:
        raise BadDrawing(unknown_name("pattern", name, tuple(PATTERNS)))
    kind = PATTERNS[name]
    for key in given:
        _check_name(name, key)
    if are_apart(given):
        return _apart(name, given)
    try:
        return kind.model_validate(given)  # type: ignore[return-value]  # each class of PATTERNS is a Pattern
    except ValidationError as error:
        first = error.errors()[0]
        key = str(first["loc"][0]) if first["loc"] else ""
        if first["type"] == "missing":
            missing = [str(one["loc"][0]) for one in error.errors() if one["type"] == "missing"]
            raise BadDrawing(f"The drawing {name} also needs {', '.join(missing)}.") from error
        reason = first["msg"].removeprefix("Value error, ")
        reason = reason[:1].lower() + reason[1:]
        if key not in given:  # numbers that are right one by one, and not together
            raise BadDrawing(f"The drawing {name} cannot be made so: {reason}.") from error
        raise BadDrawing(f"{key} of {name} cannot be {given[key]}: {reason}.") from error


def _check_name(name: str, key: str) -> None:
    """BadDrawing where the pattern has no such parameter, or none of one side alone."""
    fields, (stem, side) = PATTERNS[name].model_fields, parted(key)
    if stem not in fields:
        raise BadDrawing(unknown_name(f"parameter of {name}", key, tuple(fields)))
    if side and (stem == "side" or "side" not in fields or fields["side"].is_required()):
        raise BadDrawing(f"{stem} of {name} has no value for each side; write {stem}.")


def _apart(name: str, given: Mapping[str, float | str]) -> Pattern:
    """The pattern of each side where numbers differ; of one where only that is asked for."""
    asked = str(given.get("side", "both"))
    pattern_of(name, {"side": asked})
    sides = sides_of(asked)
    other = next((key for key in given if (side := parted(key)[1]) and side not in sides), None)
    if other is not None:
        raise BadDrawing(f"{other} of {name} is not needed: the pattern is drawn on the {SIDES[sides[0]]} side only.")
    found = []
    for side in sides:
        try:
            found.append((side, pattern_of(name, of_side(given, side))))
        except BadDrawing as error:
            raise BadDrawing(f"On the {SIDES[side]}: {error}") from error
    return Apart(tuple(found)) if len(found) > 1 else found[0][1]


def tumour_text(short: str) -> str:
    """`L:10,45,12` (side: hour, distance mm, radius mm) or `at:X,Y,Z,12` (mm) as a part of a drawing's text."""
    side, colon, rest = short.partition(":")
    numbers = rest.split(",")
    if side == "at" and len(numbers) == 4:
        return f"tumour_at:{rest}"
    if not colon or len(numbers) != 3 or side == "at":
        raise BadDrawing(
            f'"{short}" is not a tumour; write SIDE:HOUR,DISTANCE_MM,RADIUS_MM, for instance L:10,45,12 for the left '
            f"breast at 10 o'clock, 45 mm from the nipple, radius 12 mm{POINT}, or at:X,Y,Z,RADIUS in mm of the scan's "
            "frame."
        )
    return f"tumour:{side},{rest}"


def pattern_help() -> str:
    """Every pattern with its parameters, for people."""
    sentences = []
    for name, kind in PATTERNS.items():
        words = []
        for parameter, field in kind.model_fields.items():
            default = "" if field.is_required() or field.default is None else f" (if not said {field.default})"
            words.append(f"{parameter}: {field.description}{default}")
        sentences.append(f"{name} has " + "; ".join(words))
    sentences.append("a number of one side alone ends with _left or _right: areola_mm=42,areola_mm_left=38")
    return ". ".join(sentences) + "."


def _parameters(name: str, values: str) -> dict[str, str]:
    """{name: value} of a pattern's part of a text."""
    kind = PATTERNS[name]
    given: dict[str, str] = {}
    in_order = all(field.is_required() for field in kind.model_fields.values())
    names = iter(kind.model_fields)
    for pair in split_parameters(values):
        if in_order and "=" not in pair and (following := next(names, None)) is not None:
            pair = f"{following}={pair}"
        key, equals, value = (word.strip() for word in pair.partition("="))
        if not equals:
            raise BadDrawing(f'"{pair}" is not a parameter of {name}; write name=value, for instance {_example(kind)}.')
        _check_name(name, key)
        if key in given:
            raise BadDrawing(f"The parameter {key} of {name} is given twice.")
        given[key] = value
    return given


def _example(kind: type[BaseModel]) -> str:
    if kind is MastectomyEllipse:
        return "width_mm=70"
    return {Tumour: f"side=L{POINT}", PickedTumour: f"radius_mm=12{POINT}"}.get(kind, "areola_mm=42")


def _unique(shapes: list[DrawnShape]) -> tuple[DrawnShape, ...]:
    """The shapes with unique names: a second one gets a number before its side, tumour_2_L."""
    seen: Counter[str] = Counter()
    result = []
    for shape in shapes:
        seen[shape.name] += 1
        count = seen[shape.name]
        if count > 1:
            stem, side = split_side(shape.name)
            shape = replace(
                shape, name="_".join(filter(None, (stem, str(count), side))), label=f"{shape.label} {count}"
            )
        result.append(shape)
    return tuple(result)
