"""Asks for the frame of a label map whose file does not state it, and shows the outcome of each answer."""

import base64
import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadScan, NeedsAnswer
from breastrig.scan.piece import BallInside
from breastrig.scan.volumes.answers import FORMS, TakenAs
from breastrig.scan.volumes.body import Bodies
from breastrig.scan.volumes.segments import Taken, taken_segments
from breastrig.scan.volumes.volume import Reading, Volume

PIXELS = 160  # of a picture's longer side
SHOWN = 8  # choices among axes: as many have the same front
MIDDLE = 10.0  # mm from the middle on both sides
WIDE = 200.0  # mm; of a body that is less wide one side alone may be shown
CLEARLY = 0.2  # more of the front is air in one reading than in the other


def needs_answer(volume: Volume, bodies: Bodies, chosen: Mapping[int, TakenAs]) -> NeedsAnswer:
    """The error that asks, with its choices."""
    air = {reading.value: bodies.air_in_front(reading.affine) for reading in volume.readings}
    least = max(air.values()) - CLEARLY
    asked = [each for each in volume.readings if each.value in FORMS or air[each.value] > max(0.0, least)]
    if asked and asked[0].value not in FORMS:
        asked = asked[:SHOWN]  # axial slices come first
    choices, taken = [], dict[int, Taken]()  # by the body, which readings with the same front share
    for reading in asked or volume.readings[:SHOWN]:
        try:
            body = bodies.body(reading.affine)
            if id(body) not in taken:
                taken[id(body)] = taken_segments(volume, body.__getitem__, reading.affine, chosen)
            choices.append(_choice(reading, body, taken[id(body)]))
        except BadScan:  # this answer would be refused
            choices.append({"value": reading.value, "text": reading.text, "lesions": []})
    return NeedsAnswer(volume.doubt, {"field": "frame", "choices": choices})


def _choice(reading: Reading, body: Booleans, taken: Taken) -> dict[str, Any]:
    affine = reading.affine
    turn, seen = _seen(body, affine)
    lesions = [_lesion(each, affine, seen, turn, reading.value in FORMS) for each in taken.lesions]
    text = reading.text
    if lesions:
        sides = {"L": "left", "R": "right", "middle": "in the middle"}
        text += "; " + ", ".join(f"{each['name']} {sides[each['side']]}" for each in lesions)
    places = [(each["x"], each["y"]) for each in lesions]
    return {"value": reading.value, "text": text, "lesions": lesions, "picture": _picture(seen, turn, affine, places)}


def _seen(body: Booleans, affine: Array) -> tuple[NDArray[Any], Booleans]:
    """The orientation of the voxel axes (nibabel's form), and the body along left, back and up."""
    from nibabel.orientations import apply_orientation, io_orientation

    turn: NDArray[Any] = io_orientation(affine)
    return turn, np.asarray(apply_orientation(body, turn))


def _lesion(lesion: BallInside, affine: Array, seen: Booleans, turn: NDArray[Any], has_origin: bool) -> dict[str, Any]:
    place = np.zeros(3)
    shape = np.asarray(seen.shape)
    for axis, (to, sign) in enumerate(turn):
        at = lesion.center[axis]
        place[int(to)] = at if sign > 0 else shape[int(to)] - 1 - at
    share = place / (shape - 1)
    step = float(np.linalg.norm(affine[:3, int(np.flatnonzero(turn[:, 0] == 0)[0])]))
    across = np.flatnonzero(seen.any(axis=(1, 2)))
    is_wide = step * np.ptp(across) > WIDE or not has_origin
    off = step * (place[0] - across.mean()) if is_wide else float((affine @ [*lesion.center, 1.0])[0])
    side = "middle" if abs(off) < MIDDLE else "L" if off > 0.0 else "R"
    return {"name": lesion.name, "side": side, "x": round(2.0 * share[0] - 1.0, 3), "y": round(float(share[2]), 3)}


def _picture(seen: Booleans, turn: NDArray[Any], affine: Array, lesions: list[tuple[float, float]]) -> str:
    """The body from the front, the patient's right on the left, near is light: a PNG as data address."""
    depth = seen.argmax(axis=1) / max(1, seen.shape[1] - 1)
    grey = np.where(seen.any(axis=1), 235.0 - 160.0 * depth, 20.0).astype(np.uint8)
    sizes = np.zeros(3)
    sizes[turn[:, 0].astype(int)] = np.linalg.norm(affine[:3, :3], axis=0)
    wide, high = sizes[0] * seen.shape[0], sizes[2] * seen.shape[2]
    scale = PIXELS / max(wide, high)
    width, height = (max(16, round(scale * each)) for each in (wide, high))
    image = Image.fromarray(np.ascontiguousarray(grey.T[::-1])).convert("RGB").resize((width, height))
    draw = ImageDraw.Draw(image)
    for x, y in lesions:
        at, up = 0.5 * (x + 1.0) * width, (1.0 - y) * height
        draw.ellipse((at - 5, up - 5, at + 5, up + 5), outline=(255, 40, 40), width=2)
    draw.text((2, height - 12), "R", fill=(255, 255, 255))
    draw.text((width - 9, height - 12), "L", fill=(255, 255, 255))
    stream = io.BytesIO()
    image.save(stream, "PNG")
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()
