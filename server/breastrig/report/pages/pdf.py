"""report.pdf: what stands on its pages as JSON, which the Typst template report.typ sets.

The first page shows the scan with the plan and the plan's numbers; then come measures, landmarks, settings and notes;
then a tape sheet of each stance.  The same stances and the same identity give the same bytes.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from breastrig.core.identity import UNNAMED, Identity
from breastrig.core.stances import SIDES
from breastrig.drawings.line_error import ACROSS, drawn_error
from breastrig.files.result import Distances, ResultFile, SurfaceDistances
from breastrig.fitting.uncertainty.radii import HOLDS_90
from breastrig.languages.catalogue import ENGLISH
from breastrig.languages.translation import Typed
from breastrig.report.bands import KNOWN_MM, margin_text, sure_text
from breastrig.report.document import PlannedItem, Reported
from breastrig.report.measures import OUTLINE
from breastrig.report.pages.names import plainly, spoken, spoken_together
from breastrig.report.pages.printable import check_printable
from breastrig.report.pages.tape_sheet import tape_sheet
from breastrig.report.pages.typeset import typeset
from breastrig.report.pictures import (
    LEAST_SURE_MM,
    colour_bar,
    jpeg,
    scan_pictures,
    uncertainty_pictures,
    views_of,
)
from breastrig.report.resections.resection import resection_numbers
from breastrig.report.stance import places
from breastrig.report.table import (
    NOT_KNOWN,
    NOT_SEEN,
    VAGUELY_KNOWN,
    Row,
    Value,
    as_printed,
    changes,
    grade_text,
    printed_step,
    with_margin,
)
from breastrig.scan.unscaled import unscaled

PAGE_PPI = 144.0  # of pages as pictures: 1190 x 1684 pixels, on which 6.5 point type is read on a screen and on paper
KINDS = {  # of rows, in this order
    "along the skin": "Along the skin (mm)",
    "straight": "Straight (mm)",
    "in height": "Ptosis (heights in mm)",
    "grade": "Ptosis (heights in mm)",
    "volume": "Volume (ml)",
    "ratio": "Symmetry (1 = equal)",
}
VERDICTS = {
    "good": "Ready to draw",
    "uncalibrated": "Not calibrated for this rig: how far off lines may be is not known",
    "check": "To be checked (see doubts and notes)",
    "unusable": "Cannot be used (see doubts and notes)",
}
WARNINGS = {
    "uncalibrated": "NOT CALIBRATED FOR THIS RIG: see doubts and notes",
    "check": "CHECK THIS FIT: see doubts and notes",
    "unusable": "NOT USABLE: see doubts and notes",
}
NO_TRUE_SIZE = (
    "The size of a scan is not known: lengths may be {:.0f} % off, volumes {:.0f} %, also beyond their bands."
)
ASKED = "These numbers were asked for on another scan; what is drawn there is measured in that scan's report."
ENCLOSED = (
    "In columns from the skin inside the line to the estimated chest wall, a depth from the nearest skin; in brackets "
    "the wall at both ends of its interval (90 %). Grams at {:g} ± {:g} g/ml (one specimen). Breasts down to that wall "
    "({}): more than the volume among the measures, which ends before the fat behind the breast. No shape after the "
    "operation is predicted."
)
UNSEEN = "The scan shows no skin next to it: its depth is the model's guess."
REPORTED = (("by the clock", "clock"), ("beside the report of radiology", "radiology"))
PIXELS_PER_MM = 7.0  # 180 to the inch
LARGE = (88.0, 92.0)  # mm, the scan with the plan
SMALL = (42.0, 44.0)  # mm, the map of uncertainty

Table = dict[str, Any]


def report_pdf(stances: Sequence[Reported], identity: Identity = UNNAMED, language: str = ENGLISH) -> bytes:
    """The pages of one or two stances; BadInput where a word has characters that no font has."""
    return bytes(_set(stances, identity, language))


def report_pages(stances: Sequence[Reported], identity: Identity = UNNAMED, language: str = ENGLISH) -> list[bytes]:
    """The same pages as PNG, sharp enough to be printed; BadInput likewise."""
    pages = _set(stances, identity, language, format="png", ppi=PAGE_PPI)
    return [bytes(page) for page in ([pages] if isinstance(pages, bytes) else pages)]


def _set(stances: Sequence[Reported], identity: Identity, language: str, **form: Any) -> Any:
    check_printable([("The patient's code", identity.code), *_written(stances)])
    return typeset("pages", "report.typ", report_content(stances, identity), language, **form)


def _written(stances: Sequence[Reported]) -> list[tuple[str, str]]:
    """The texts that people have written: names of lines and items, and notes."""
    lines = [("The name of a line", line.name) for one in stances for line in one.stance.lines]
    items = [(f"“{item.name}”", f"{item.name} {item.text}") for one in stances for item in one.plan]
    lesions = [("The name of a lesion", str(lesion["name"])) for one in stances for lesion in one.lesions]
    return [*lines, *items, *lesions]


def report_content(stances: Sequence[Reported], identity: Identity) -> dict[str, Any]:
    """All data of the template."""
    made = identity.made
    levels = [one.result.verdict.level if one.result.verdict else "good" for one in stances]
    warned = [
        f"{WARNINGS[level]} ({one.name})" for one, level in zip(stances, levels, strict=True) if level in WARNINGS
    ]
    return {
        "made": None if made is None else [made.year, made.month, made.day, made.hour, made.minute, made.second],
        "code": Typed(identity.code),
        "facts": _facts(stances, identity),
        "checkable": not any(one.result.predicted for one in stances),
        "warning": " · ".join(warned),
        "verdicts": [_verdict(one) for one in stances],
        "pictures": _large_pictures(stances),
        "legend": _legend(stances),
        "plan": _plan(stances),
        "lesions": _lesions(stances),
        "resections": [each for one in stances for each in _resections(one, len(stances) > 1)],
        "lines": _lines(stances),
        "measures": _measures(stances),
        "landmarks": _landmarks(stances),
        "uncertainty": _uncertainty(stances),
        "settings": _settings(stances),
        "doubts": [*stances[0].doubts, *_remarks(stances)],
        "measured": sorted({row.measure for one in stances for row in one.rows}),
        "no_true_size": _no_true_size(stances),
        "tape": [sheet for one in stances if (sheet := tape_sheet(one.name, one.stance)) is not None],
    }


def _no_true_size(stances: Sequence[Reported]) -> str:
    """How far off all numbers may be besides; empty where the sizes of all scans are known."""
    share = HOLDS_90 * unscaled().deviation
    known = all(one.result.size_known for one in stances)
    return "" if known else NO_TRUE_SIZE.format(100.0 * share, 100.0 * ((1.0 + share) ** 3 - 1.0))


def _facts(stances: Sequence[Reported], identity: Identity) -> list[list[str]]:
    """(what, day or the empty text where it is to be filled in) of each scan and of the plan."""
    days = identity.scanned or ("",) * len(stances)
    word = "scan received" if identity.received else "scanned"
    words = [f"from the {word}" if one.result.predicted else word for one in stances]
    facts = [[f"{one.name}, {said}", day] for one, said, day in zip(stances, words, days, strict=True)]
    if identity.plan_version:
        facts.append([f"plan, version {identity.plan_version}", identity.planned])
    elif any(one.plan for one in stances):
        facts.append(["plan", identity.planned])
    return facts


def _large_pictures(stances: Sequence[Reported]) -> list[Table]:
    """Two views of one stance, or the front view of each of two, in one scale."""
    views = ("front", "three_quarter") if len(stances) == 1 else ("front",)
    aspect = LARGE[0] / LARGE[1]
    height = max(view.height for one in stances for view in views_of(one.stance, views, aspect))
    found = []
    for one in stances:
        cameras = views_of(one.stance, views, aspect, height)
        for name, picture in zip(views, scan_pictures(one.stance, cameras, _pixels(LARGE)), strict=True):
            shown = "not scanned" if one.result.predicted else "scan"
            what = f"{shown} with the plan" if one.plan else f"{shown} with the drawing" if one.stance.lines else shown
            title = f"{one.name.capitalize()}, {name.replace('_', ' ')}"
            found.append({"title": f"{title}: {what}", "jpeg": list(jpeg(picture)), "predicted": one.result.predicted})
    return found


def _legend(stances: Sequence[Reported]) -> str:
    """One line on the look of the lines in the pictures, and which of them is the least sure; empty without lines."""
    banded = [line for one in stances for line in one.stance.banded]
    errors = [np.array([np.nan]) if line.error is None else line.error for line in banded]
    known = [1e3 * ACROSS * error <= KNOWN_MM for error in errors]
    words = ["grey: holds the true line nine times in ten"] if any(each.any() for each in known) else []
    words += [] if all(each.all() for each in known) else ["hatched: not known"]
    if any(one.stance.predicted or line.bridged.any() for one in stances for line in one.stance.lines):
        words.append("dashed: no scan shows the skin there")
    sure = [
        (metres, f"{spoken(line.name)}, {one.name}" if len(stances) > 1 else spoken(line.name))
        for one in stances
        for line in one.stance.banded
        if (metres := drawn_error([line])) is not None
    ]
    if sure:
        metres, name = max(sure)
        words.append(f"the least sure line: {name}, {margin_text(1e3 * metres)}")
    text = "; ".join(words)
    return f"{text[:1].upper()}{text[1:]}." if text else ""


def _pixels(size: tuple[float, float]) -> tuple[int, int]:
    return round(PIXELS_PER_MM * size[0]), round(PIXELS_PER_MM * size[1])


def _plan(stances: Sequence[Reported]) -> list[Table]:
    """Each item once, also where both stances show it: what differs, a lesion's depth and error, with its stance."""
    items = dict.fromkeys(item.id for one in stances for item in one.plan)
    return [_planned([(one.name, item) for one in stances for item in one.plan if item.id == each]) for each in items]


def _planned(shown: Sequence[tuple[str, PlannedItem]]) -> Table:
    """The rows of one item, as (stance, item)."""
    found: dict[str, dict[str, str]] = {}  # of what, value, stance that has it first
    where_drawn = [each for each in shown if each[1].is_drawn] or shown
    for stance, item in where_drawn:
        for what, value in item.values:
            found.setdefault(what, {}).setdefault(value, stance)
    values: list[tuple[str, str]] = []
    for what, each in found.items():
        if len({*each.values()}) == 1:
            values += [(what, value) for value in each]
        else:
            values.append((what, ", ".join(f"{value} {stance}" for value, stance in each.items())))
    text, words = (
        " ".join(dict.fromkeys(filter(None, each)))
        for each in zip(*((item.text, item.said) for _, item in shown), strict=True)
    )
    if values and not any(item.is_drawn for _, item in shown):
        words = f"{ASKED} {words}".rstrip()
    return {"name": shown[0][1].name, "values": values, "text": Typed(text), "said": words}


def _lesions(stances: Sequence[Reported]) -> list[Table]:
    """Each lesion with a row of numbers and its slices for every stance that shows it."""
    shown = [(one.name, lesion) for one in stances for lesion in one.lesions]
    return [
        {
            "name": Typed(next(lesion["name"] for _, lesion in shown if lesion["id"] == each)),
            "stances": [
                {
                    "stance": stance,
                    "values": _lesion_values(lesion),
                    "doubt": "" if lesion["seen"] else UNSEEN,
                    "slices": lesion["slices"],
                    "radius": lesion["radius_mm"],
                    "error": lesion["error_mm"] or 0.0,
                }
                for stance, lesion in shown
                if lesion["id"] == each
            ],
        }
        for each in dict.fromkeys(lesion["id"] for _, lesion in shown)
    ]


def _resections(one: Reported, is_named: bool) -> list[Table]:
    """A table of each closed line on a breast; `is_named`: with the name of its stance."""
    numbers = resection_numbers()
    return [
        {
            "title": f"{spoken(each.line)}{f', {one.name}' if is_named else ''}",
            "rows": [
                [
                    _down_to(row.depth, one.depths.get(each.line)),
                    _ml(row.volume)
                    if row.band is None
                    else f"{_ml(row.volume)} ({_ml(row.band[0])} to {_ml(row.band[1])})",
                    f"{1e6 * numbers.density_g_per_ml * row.volume:.0f}",
                    f"{100.0 * row.share:.0f} %",
                    _ml(row.after),
                    _ml(row.other),
                ]
                for row in each.rows
            ],
            "how": ENCLOSED.format(
                numbers.density_g_per_ml,
                numbers.density_deviation,
                f"{SIDES[each.side]} {_ml(each.breast)} ml, other side {_ml(each.other_breast)} ml",
            ),
        }
        for each in one.resections
    ]


def _down_to(depth: float | None, planned: float | None) -> str:
    if depth is None:
        return "to the chest wall"
    return f"to {1e3 * depth:.4g} mm{', as planned' if depth == planned else ''}"


def _ml(cubic_metres: float) -> str:
    return f"{1e6 * cubic_metres:.0f}"


def _lesion_values(lesion: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The numbers of a lesion; of the lines only the nearest."""
    error = lesion["error_mm"]
    off = "as given" if error == 0.0 else margin_text(error)
    distances = [each for each in lesion["distances"] if each["kind"] != "line"]
    distances += [each for each in lesion["distances"] if each["kind"] == "line"][:1]
    return [
        ("radius", f"{lesion['radius_mm']:.3g} mm"),
        *((f"to {_whither(each)}", _banded(each)) for each in distances),
        ("its place", off),
        *((what, lesion[key]["text"]) for what, key in REPORTED if key in lesion),
    ]


def _whither(distance: Mapping[str, Any]) -> str:
    name = spoken(distance["to"]) + (" of the image" if distance.get("seen") else "")
    return name if distance["kind"] == "line" else f"the {name.lower()}"


def _banded(distance: Mapping[str, Any]) -> str:
    """A number with its band: 12 mm, 8 to 17."""
    band = "" if distance["low_mm"] is None else f", {distance['low_mm']:.0f} to {distance['high_mm']:.0f}"
    return f"{distance['mm']:.0f} mm{band}"


def _lines(stances: Sequence[Reported]) -> str:
    """Names of the lines that are drawn where there is no plan: the fit's own drawing."""
    if any(one.plan for one in stances):
        return ""
    return "; ".join(dict.fromkeys(spoken(line.name) for one in stances for line in one.stance.lines))


def _measures(stances: Sequence[Reported]) -> Table:
    """Groups of rows, each with the cells of left, right and L - R for every stance and for their change."""
    columns = [one.name for one in stances]
    if len(stances) == 2:
        columns.append(f"change, {stances[0].name} to {stances[1].name}")
    rows = {row.key: row for one in reversed(stances) for row in one.rows}
    groups: dict[str, list[Any]] = {}
    for kind, title in KINDS.items():
        for key in (each for each in rows if each[1] == kind):
            cells = _cells_of([[row for row in one.rows if row.key == key] for one in stances])
            groups.setdefault(title, []).append([rows[key].label, cells])
    return {
        "columns": columns,
        "groups": [{"title": title, "rows": found} for title, found in groups.items()],
    }


def _cells_of(of_stances: Sequence[Sequence[Row]]) -> list[list[str]]:
    """The cells of one measure, of each stance that has it and of the change."""
    step = printed_step([row for rows in of_stances for row in rows])
    shown = [[as_printed(row, step) for row in rows] for rows in of_stances]
    columns = [(rows, False) for rows in shown] + ([(changes(*shown), True)] if len(shown) == 2 else [])
    return [_cells(rows[0], step, is_change) if rows else ["", "", ""] for rows, is_change in columns]


def _cells(row: Row, step: float, is_change: bool) -> list[str]:
    """Left, right and their difference; or one text for both breasts."""

    def text(side: str, value: Value | None) -> str:
        if value is None and side in (*row.not_seen, *row.not_known):
            return NOT_SEEN if side in row.not_seen else NOT_KNOWN
        if side in row.vague:
            return VAGUELY_KNOWN
        return (
            grade_text(value)
            if row.unit == "grade"
            else with_margin(value, row.unit, step, is_change or side == "difference")
        )

    if row.value is not None or "value" in (*row.not_seen, *row.not_known):
        return [text("value", row.value)]
    between = "" if row.difference is None else text("difference", row.difference)
    between = NOT_KNOWN if "difference" in row.not_known else between
    cells = [text("left", row.left), text("right", row.right), between]
    return cells[:1] if {*cells} == {VAGUELY_KNOWN} else cells


def _landmarks(stances: Sequence[Reported]) -> Table:
    """For each landmark and stance: its source, the distance from model to pick, and its 90 % radius."""
    placed = [places(one.stance) for one in stances]
    names = list(dict.fromkeys(name for found in placed for name in found))
    rows = []
    for name in names:
        cells = []
        for one, found in zip(stances, placed, strict=True):
            gap = one.result.landmark_distance_mm.each.get(name)
            radius = one.result.landmark_uncertainty_mm.get(name)
            texts = ["-" if gap is None else f"{gap:.1f}", "-" if radius is None else _margin(radius)]
            cells.append([found[name].source if name in found else "-", *texts])
        rows.append([spoken(name), cells])
    return {"columns": [one.name for one in stances], "rows": rows}


def _uncertainty(stances: Sequence[Reported]) -> Table | None:
    """Maps of the skin's 90 % radii over the body; None where no fit has them."""
    pictures = []
    for one in stances:
        if one.stance.radii is not None:
            cameras = views_of(one.stance, ("front", "left"), SMALL[0] / SMALL[1])
            pictures += [list(jpeg(each)) for each in uncertainty_pictures(one.stance, cameras, _pixels(SMALL))]
    if not pictures:
        return None
    return {"pictures": pictures, "bar": list(jpeg(colour_bar(600, 24))), "most": f"{LEAST_SURE_MM:.0f} mm and more"}


def _settings(stances: Sequence[Reported]) -> Table:
    said = [_making(one.result) for one in stances]
    return {
        "columns": [one.name for one in stances],
        "rows": [[name, [each[name] for each in said]] for name in said[0]],
    }


def _margin(radius: float) -> str:
    """A radius in mm as text."""
    return "not known" if radius > KNOWN_MM else f"±{radius:.1f}"


def _verdict(one: Reported) -> str:
    """The verdict with the line error, then the landmarks'; results of earlier versions have fewer numbers."""
    result = one.result
    level = VERDICTS[result.verdict.level if result.verdict else "check"]
    sure = sure_text(result, one.drawn_mm)
    return f"{one.name.capitalize()}: {level}{sure and f': {sure}'}."


def _making(result: ResultFile) -> dict[str, str]:
    """Facts on the fit; for a prediction on the fit it comes from."""
    scan, model, landmarks = result.scan, result.model, result.landmark_distance_mm
    mean, most, count = landmarks.mean, landmarks.max, len(landmarks.each)
    picked = "no landmarks were picked" if mean is None else f"mean {mean:.1f} mm, largest {most:.1f} mm, of {count}"
    alone = result.distances.surface_distance_mm
    return {
        "Stance": result.stance_reason,
        "Model to picked landmarks": picked,
        "Model to scan": _distances(result.surface_distance_mm),
        "Without the free-form layer": _distances(alone) if result.refined else "the same",
        "Scan to model": _distances(result.scan_to_model_mm),
        "End of the fit": f"{result.stop_reason.rstrip('.')}; {result.iterations} steps",
        "Preset": f"{result.preset}{', on the skin' if result.refined else ''}",
        "Scan": f"{scan.vertices:,} points, {scan.triangles:,} triangles, {scan.unit}; {scan.sha256[:12]}",
        "Model": f"{model.name}, {model.bones} bones, {model.blendshapes} shapes; {model.sha256[:12]}",
        "Versions": ", ".join(f"{name} {version}" for name, version in result.versions.items()),
    }


def _distances(found: Distances) -> str:
    if found.mean is None:
        return "none: the scan shows no skin near the model"
    words = f"mean {found.mean:.2f} mm, 95 % {found.p95:.2f} mm, largest {found.max:.1f} mm"
    return f"{words}; {100 * found.coverage:.0f} % seen" if isinstance(found, SurfaceDistances) else words


def _remarks(stances: Sequence[Reported]) -> list[str]:
    """The remarks of each stance, with its name where there are two."""
    prefixes = [f"{one.name.capitalize()}: " if len(stances) > 1 else "" for one in stances]
    return [prefix + remark for prefix, one in zip(prefixes, stances, strict=True) for remark in _doubts(one)]


def _doubts(one: Reported) -> list[str]:
    """Reasons to check the fit, unusual picks and those not followed, patterns that do not fit, and reading notes."""
    result = one.result
    reasons = list(result.verdict.reasons) if result.verdict else []
    reasons += [pick.reason for pick in (*result.landmarks_not_followed, *result.landmarks_unusual)]
    reasons += [*(() if one.plan else result.drawing_missing), *result.notes]  # a plan says itself what is missing
    reasons = [plainly(reason, one.stance.rig.landmark_names) for reason in reasons]
    named = dict.fromkeys(name for row in one.rows for name in row.landmarks)
    unpicked = [name.removesuffix(" (model)") for name in named if name.endswith(" (model)") and name != OUTLINE]
    if unpicked:
        reasons.append(f"Measured from the model's own place: {', '.join(spoken_together(unpicked))}.")
    return reasons
