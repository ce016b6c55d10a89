"""The page for taking scans with marks: where the dots are, how the arms lie, one length, the order of the scans."""

from functools import cache
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.languages.catalogue import ENGLISH
from breastrig.rendering.picture import Layer, Scene, camera
from breastrig.report.pages.typeset import typeset
from breastrig.report.pictures import SCAN_GREY, jpeg
from breastrig.rig.model import Rig

NAME = "scan_protocol.pdf"
# Of the left side: shares of landmarks, looked for on the skin from the front.  The first are on the breast, whose
# lines they narrow (docs/decisions/0034-marks.md), the others around it.
DOTS: tuple[tuple[str, dict[str, float]], ...] = (
    ("above the areola, half way to the collarbone", {"nipple": 0.55, "midclavicle": 0.45}),
    ("towards the breastbone, half way to it", {"nipple": 0.5, "mid_sternum": 0.5}),
    ("towards the arm, two fingers from the nipple", {"nipple": 1.15, "mid_sternum": -0.15}),
    ("between areola and fold", {"nipple": 0.5, "inframammary_fold": 0.5}),
    ("towards the armpit, at the edge of the breast", {"nipple": 0.7, "acromion": 0.5, "mid_sternum": -0.2}),
    ("two fingers below the fold", {"inframammary_fold": 1.6, "nipple": -0.6}),
    ("beside the breastbone, a hand's breadth below the notch", {"mid_sternum": 0.55, "midclavicle": 0.45}),
    (
        "at the side, a hand's breadth below the fold",
        {"inframammary_fold": 1.0, "nipple": 0.35, "mid_sternum": -0.55, "umbilicus": 0.2},
    ),
)
FIRST = 4  # of each side, where eight are enough
PIXELS = 900


@cache
def protocol_pdf(language: str = ENGLISH) -> bytes:
    """The page as PDF: always the same bytes."""
    return bytes(typeset("pages", "protocol.typ", _content(read_rig(default_rig_path())), language))


def _content(rig: Rig) -> dict[str, Any]:
    """All data of the template; places of dots are shares of the picture from its left upper corner."""
    view = camera("front", rig.template, margin=0.02)
    picture = Scene([Layer(rig.template, rig.faces, SCAN_GREY)]).render(view, (PIXELS, PIXELS))
    count, marks = len(DOTS), []
    for number, at in enumerate(dots(rig), start=1):
        right, up, _ = view.axes @ (at - view.centre) / view.height
        is_first = (number - 1) % count < FIRST
        marks.append({"number": str(number), "x": 0.5 + right, "y": 0.5 - up, "first": is_first})
    return {
        "picture": list(jpeg(picture)),
        "marks": marks,
        "places": [[f"{k} · {k + count}", place] for k, (place, _) in enumerate(DOTS, start=1)],
        "few": f"Eight are enough: 1 to {FIRST} and {count + 1} to {count + FIRST}, the filled ones.",
    }


def dots(rig: Rig) -> list[Array]:
    """(3,) m each, on the model at rest: those of the left side, then those of the right."""
    points = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    found = []
    for side in "LR":
        for _, shares in DOTS:
            parts = [share * points[name if name in points else f"{name}_{side}"] for name, share in shares.items()]
            found.append(_on_front(rig, np.sum(parts, axis=0)))
    return found


def _on_front(rig: Rig, at: Array) -> Array:
    """The vertex that one sees there from the front."""
    ahead = rig.template[rig.template[:, 2] > np.median(rig.template[:, 2])]
    return np.asarray(ahead[np.argmin(np.linalg.norm(ahead[:, :2] - at[:2], axis=1))])
