"""What our own torso must keep, beside the rules for any rig: what the surgeon needs from it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import boundary_loops, directed_edges
from breastrig.rig.model import Rig
from breastrig.rig.validation.finding import Finding, named
from breastrig.rig.validation.rules import check_rig
from breastrig.rig.validation.symmetry import other_side

VERTICES = (2000, 2600)
BONES = (
    "pelvis",
    "lumbar",
    "lower_thorax",
    "upper_thorax",
    "neck",
    "shoulder_L",
    "shoulder_R",
    "upper_arm_L",
    "upper_arm_R",
)
SHAPES = 55
LANDMARKS = (  # at least: pages, measures and patterns know these by name
    "suprasternal_notch",
    "mid_sternum",
    "xiphoid",
    "midclavicle_L",
    "midclavicle_R",
    "acromion_L",
    "acromion_R",
    "nipple_L",
    "nipple_R",
    "inframammary_fold_L",
    "inframammary_fold_R",
    "umbilicus",
)
DRAWINGS: dict[str, tuple[str, ...]] = {
    "lumpectomy": ("sternum_upper", "sternum_lower", "breast_L", "breast_R"),
    "anatomy": (
        "midline",
        *(
            f"{line}_{side}"
            for line in ("meridian_upper", "meridian_lower", "inframammary_fold", "breast_base", "anterior_axillary")
            for side in "LR"
        ),
    ),
    "mastectomy": ("stewart_L", "stewart_R"),
}
BREAST_EDGE = 0.009  # m, the median on the breasts
OPENINGS = 4  # waist, neck, two arms
AREOLA_RINGS = 4  # closed rings of edges around each nipple
RING_SPREAD = 0.25  # relative spread of a ring's distances from the nipple

# Each side needs a shape for every line, the whole torso too: one of the words must be in a name.
BREAST_TOPICS: dict[str, tuple[str, ...]] = {
    "volume": ("volume", "size", "large", "small", "cup"),
    "ptosis or firmness": ("ptosis", "firm", "sag"),
    "projection": ("projection",),
    "upper inner quadrant": ("upper_inner", "upper_medial"),
    "upper outer quadrant": ("upper_outer", "upper_lateral"),
    "lower inner quadrant": ("lower_inner", "lower_medial"),
    "lower outer quadrant": ("lower_outer", "lower_lateral"),
    "roundness of the apex": ("round", "apex", "cone", "conical", "point"),
    "position to the side": ("lateral", "medial", "sideways", "apart", "outwards", "position_x", "distance"),
    "position in height": ("height", "up", "raised", "lowered", "vertical", "position_y"),
    "base width": ("base", "width"),
    "supine spread": ("supine", "spread", "lying"),
    "nipple up and down": ("nipple",),
    "areola size": ("areola",),
}
BODY_TOPICS: dict[str, tuple[str, ...]] = {
    "shoulder width": ("shoulder_width", "shoulders_width", "shoulder_wide", "shoulders_wide"),
    "shoulder slope": ("slope",),
    "chest depth": ("chest_depth", "thorax_depth"),
    "chest width": ("chest_width", "thorax_width"),
    "chest height": ("chest_height", "thorax_height"),
    "pectoral muscle": ("pectoral",),
    "latissimus muscle": ("latissimus", "dorsi"),
    "waist": ("waist",),
    "upper belly": ("belly_upper", "upper_belly"),
    "lower belly": ("belly_lower", "lower_belly"),
    "belly flattening when supine": ("belly_supine", "supine_belly", "belly_flat", "belly_lying"),
    "hips": ("hip",),
    "overall weight": ("weight",),
    "muscle": ("muscle",),
    "neck": ("neck",),
    "back curvature": ("back",),
}


def torso_findings(rig: Rig) -> list[Finding]:
    """The finding of each rule for any rig, whose advice is law here, and for the torso alone."""
    findings = check_rig(rig)
    if all(finding.ok for finding in findings[:3]):  # the arrays fit together
        findings += [
            _size(rig),
            _names("it has the nine bones", rig.bone_names, BONES),
            _names("it has the twelve landmarks", rig.landmark_names, LANDMARKS, others=True),
            *_drawings(rig),
            _partners(rig),
            _shape_count(rig),
            _topics(rig),
            _own_side(rig),
            _openings(rig),
            _resolution(rig),
            *_areolas(rig),
            _places(rig),
        ]
    return [replace(finding, severity="error") for finding in findings]


def _size(rig: Rig) -> Finding:
    low, high = VERTICES
    count = len(rig.template)
    return Finding("the size is right", low <= count <= high, f"{count} vertices, wanted are {low} to {high}")


def _names(name: str, found: tuple[str, ...], wanted: tuple[str, ...], *, others: bool = False) -> Finding:
    """Checks the names; `others`: whether more than these are allowed."""
    missing, surplus = sorted(set(wanted) - set(found)), sorted(set(found) - set(wanted))
    if others:
        detail = f"missing: {named(missing)}." if missing else "all" + (f", and {named(surplus)}" if surplus else "")
        return Finding(name, not missing, detail)
    detail = f"{len(found)}"
    if missing or surplus:
        detail = f"missing: {named(missing) or 'none'}; not expected: {named(surplus) or 'none'}."
    return Finding(name, not missing and not surplus, detail)


def _drawings(rig: Rig) -> list[Finding]:
    findings = []
    for wanted, shapes in DRAWINGS.items():
        drawing = next((drawing for drawing in rig.drawings if drawing.name == wanted), None)
        have = [shape.name for shape in drawing.shapes] if drawing else []
        missing = [shape for shape in shapes if shape not in have]
        detail = f"{len(have)} lines"
        if drawing is None:
            detail = "it is missing."
        elif missing or not have:
            detail = f"it lacks {named(missing) or 'every line'}."
        findings.append(Finding(f"it has the drawing {wanted}", bool(have) and not missing, detail))
    return findings


def _partners(rig: Rig) -> Finding:
    wrong = [
        f"{shape.name} of {drawing.name}"
        for drawing in rig.drawings
        for shape in drawing.shapes
        if other_side(shape.name) not in {other.name for other in drawing.shapes}
    ]
    detail = f"without the other side's: {named(wrong)}." if wrong else "all of them"
    return Finding("every line has its partner", not wrong, detail)


def _shape_count(rig: Rig) -> Finding:
    return Finding("it has 55 shapes", len(rig.shapes) == SHAPES, f"{len(rig.shapes)}")


def _topics(rig: Rig) -> Finding:
    missing = []
    for topic, words in BODY_TOPICS.items():
        if not any(word in name for name in rig.shape_names for word in words):
            missing.append(topic)
    for side in ("_L", "_R"):
        own = [name for name in rig.shape_names if name.endswith(side)]
        for topic, words in BREAST_TOPICS.items():
            wanted = 2 if words == ("nipple",) else 1  # nipple position has two directions
            if sum(any(word in name for word in words) for name in own) < wanted:
                missing.append(f"{topic} ({side[1]})")
    detail = f"no shape's name speaks of: {named(missing, 40)}." if missing else "all topics of the specification"
    return Finding("the shapes cover breast and body", not missing, detail)


def _own_side(rig: Rig) -> Finding:
    """Checks that a shape of one breast does not move the other."""
    wrong = []
    for shape, displacement in zip(rig.shapes, rig.blendshapes, strict=True):
        other = rig.regions.get("breast_R" if shape.name.endswith("_L") else "breast_L")
        if not shape.name.endswith(("_L", "_R")) or other is None:
            continue
        size = np.linalg.norm(displacement, axis=1)
        far = other[np.abs(rig.template[other, 0]) > 0.02]
        if size[far].max(initial=0.0) > 0.02 * size.max():
            wrong.append(shape.name)
    detail = f"they also move the other breast: {named(wrong)}." if wrong else "sided shapes keep to their side"
    return Finding("each breast has its own shapes", not wrong, detail)


def _openings(rig: Rig) -> Finding:
    loops = boundary_loops(rig.faces)
    detail = f"{len(loops)} borders of {', '.join(str(len(loop)) for loop in loops)} vertices"
    return Finding("waist, neck and arms are open", len(loops) == OPENINGS, detail)


def _resolution(rig: Rig) -> Finding:
    name = "the breasts are finer than the rest"
    regions = [rig.regions.get(region) for region in ("breast_L", "breast_R")]
    if regions[0] is None or regions[1] is None:
        return Finding(name, False, "the regions breast_L and breast_R are missing.")
    inside = np.zeros(len(rig.template), dtype=np.bool_)
    inside[np.concatenate([regions[0], regions[1]])] = True
    edges = np.unique(np.sort(directed_edges(rig.faces), axis=1), axis=0)
    lengths = np.linalg.norm(rig.template[edges[:, 0]] - rig.template[edges[:, 1]], axis=1)
    breast: Booleans = np.asarray(inside[edges].all(axis=1))
    if not breast.any() or breast.all():
        return Finding(name, False, "the regions breast_L and breast_R are empty or everything.")
    fine, coarse = float(np.median(lengths[breast])), float(np.median(lengths[~breast]))
    detail = f"median edge {1e3 * fine:.1f} mm on the breasts, {1e3 * coarse:.1f} mm elsewhere"
    return Finding(name, fine <= BREAST_EDGE and coarse >= 1.3 * fine, detail)


def _areolas(rig: Rig) -> list[Finding]:
    """Checks that rings of neighbours around the nipple's vertex keep a nearly constant distance from it."""
    findings = []
    for landmark in rig.landmarks:
        if landmark.name not in ("nipple_L", "nipple_R"):
            continue
        tip = int(rig.faces[landmark.face][landmark.barycentric.argmax()])
        spreads = []
        for ring in _rings(rig.faces, tip, AREOLA_RINGS):
            away = np.linalg.norm(rig.template[ring] - rig.template[tip], axis=1)
            spreads.append(float(np.ptp(away) / away.mean()))
        ok = landmark.barycentric.max() > 0.99 and max(spreads) < RING_SPREAD
        numbers = ", ".join(f"{spread:.2f}" for spread in spreads)
        findings.append(
            Finding(f"areola and {landmark.name} have rings of edges", ok, f"spread of the rings around it: {numbers}")
        )
    return findings


def _rings(faces: Integers, start: int, count: int) -> list[Integers]:
    inside = {start}
    rings = []
    for _ in range(count):
        touching = faces[np.isin(faces, list(inside)).any(axis=1)]
        ring = set(touching.ravel().tolist()) - inside
        rings.append(np.array(sorted(ring), dtype=np.int64))
        inside |= ring
    return rings


def _places(rig: Rig) -> Finding:
    """Checks that landmarks are at anatomical places: finds swapped sides and a rig in another frame."""
    places: dict[str, Array] = dict(
        zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True)
    )
    name = "landmarks are where a body has them"
    if set(LANDMARKS) - set(places):
        return Finding(name, False, "some are missing.")
    wrong = [n for n in LANDMARKS if n.endswith("_L") and places[n][0] <= 0]
    order = ("suprasternal_notch", "mid_sternum", "xiphoid", "umbilicus")
    wrong += [b for a, b in pairwise(order) if places[a][1] <= places[b][1]]
    low = float(rig.template[:, 1].min())
    if places["umbilicus"][1] - low < 0.03:
        wrong.append("umbilicus (nearer than 30 mm to the lower border)")
    for n in ("nipple_L", "nipple_R", "umbilicus"):
        if places[n][2] < np.median(rig.template[:, 2]):
            wrong.append(f"{n} (not in front)")
    return Finding(name, not wrong, f"wrong: {named(wrong)}." if wrong else "left, right, order and front")
