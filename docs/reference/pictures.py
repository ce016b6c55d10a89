"""Renders the pictures of the reference pages from the model and the example: python docs/reference/pictures.py

docs/pictures/landmarks: one of each landmark, and all. docs/pictures/patterns: one of each pattern and drawing, with
its defaults. Nothing but the package and Pillow is needed; the same model gives the same pictures.
"""

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from breastrig.core.arrays import Array
from breastrig.core.assets import packaged_models
from breastrig.core.stances import split_side
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.patterns import PATTERNS, pattern_of
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rendering.picture import Camera, Layer, Line, Picture, Scene, camera
from breastrig.rig.model import DrawnShape, Rig

FOLDER = Path(__file__).parents[1] / "pictures"
INK = (0.76, 0.10, 0.16)
DOT, RING = 9.0, 15  # pixels: width of a dot, radius of the ring around one
CLOSE = 0.24  # m that the picture of one landmark is high
SIZE = (320, 240)
ABOVE, BELOW = ("midclavicle",), ("suprasternal_notch",)  # where names stand that would cover others beside their dots
NEEDED = {  # of patterns that have no default for all parameters: the left breast, at half past one
    "tumour": {"side": "L", "clock": 1.5, "distance_mm": 45.0, "radius_mm": 12.0},
}


def all_landmarks(rig: Rig) -> Picture:
    """The front with every landmark and its name."""
    view = camera("front", rig.template, margin=0.02)
    points = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    size = (720, 720)
    picture = Scene([Layer(rig.template, rig.faces)]).render(view, size, [dot(at) for at in points.values()])
    image = Image.fromarray(picture)
    pen = ImageDraw.Draw(image)
    pixel = view.height / size[1]
    for name, at in points.items():
        x, y, _ = view.axes @ (at - view.centre)
        right, low = size[0] / 2 + x / pixel, size[1] / 2 - y / pixel
        stem, side = split_side(name)
        aside = -9 if side == "R" else 9
        beside = ("rm" if side == "R" else "lm", aside, 0)
        anchor, dx, dy = ("mb", 0, -9) if stem in ABOVE else ("mt", 0, 9) if stem in BELOW else beside
        pen.text((right + dx, low + dy), name, (30, 34, 42), font_size=15, anchor=anchor)
    return np.asarray(image)


def one_landmark(rig: Rig, stem: str) -> Picture:
    """The skin around a landmark, of both sides the left one."""
    name = next(name for name in rig.landmark_names if name in (stem, f"{stem}_L"))
    [at] = rig.landmark_points((name,)).positions(rig.template, rig.faces)
    front = Camera(at, camera("front", rig.template).axes, CLOSE)
    image = Image.fromarray(Scene([Layer(rig.template, rig.faces)]).render(front, SIZE))
    pen = ImageDraw.Draw(image)
    for radius in (1.5, RING):
        pen.circle((SIZE[0] / 2, SIZE[1] / 2), radius, outline=tuple(round(255 * part) for part in INK), width=3)
    return np.asarray(image)


def dot(at: Array) -> Line:
    return Line(at[None], INK, DOT)


def drawn(rig: Rig, shapes: tuple[DrawnShape, ...]) -> Picture:
    """Both breasts with these lines, on the model at rest."""
    lines = [
        Line(
            shape.points.positions(rig.template, rig.faces),
            tuple(int(shape.color[k : k + 2], 16) / 255 for k in (1, 3, 5)),
            3.0,
            shape.closed,
        )
        for shape in shapes
    ]
    breasts = np.concatenate([rig.template[rig.regions[f"breast_{side}"]] for side in "LR"])
    view = camera("front", breasts, aspect=1.5, margin=0.12)
    return Scene([Layer(rig.template, rig.faces)]).render(view, (480, 320), lines)


def patterns(rig: Rig) -> Mapping[str, Picture]:
    """A picture of each pattern, on this model, and of each drawing of the package's models, the first that has it."""
    skin, found = FittedSkin(rig, rig.template), dict[str, Picture]()
    for path in packaged_models().values():
        model = read_rig(path)
        found = {each.name: drawn(model, each.shapes) for each in model.drawings} | found
    for name in PATTERNS:
        if name != "tumour_at":  # its picture would be that of `tumour`
            found[name] = drawn(rig, pattern_of(name, NEEDED.get(name, {})).drawn(skin))
    return found


def all_pictures(rig: Rig) -> Mapping[str, Picture]:
    """Each by its place in docs/pictures."""
    stems = dict.fromkeys(split_side(name)[0] for name in rig.landmark_names)
    landmarks = {"all": all_landmarks(rig), **{stem: one_landmark(rig, stem) for stem in stems}}
    made = {"landmarks": landmarks, "patterns": patterns(rig)}
    return {f"{kind}/{name}.webp": picture for kind, pictures in made.items() for name, picture in pictures.items()}


def main() -> None:
    for name, picture in all_pictures(read_rig(default_rig_path())).items():
        (FOLDER / name).parent.mkdir(exist_ok=True)
        Image.fromarray(picture).save(FOLDER / name, quality=80, method=6)
        print(name)


if __name__ == "__main__":
    sys.exit(main())
