"""Pictures of the built model, for looking: `python model_assets/contact_sheet.py -o FOLDER [--model GLB]`.

Writes the template, every shape at weight 1 and at its extremes, posed extremes, and the drawings.
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from breastrig.core.arrays import Array
from breastrig.core.srgb import Reals
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import read_rig
from breastrig.rendering.picture import Camera, Layer, Line, Paint, Scene, camera
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose, shaped

HERE = Path(__file__).resolve().parent
EDGE = (0.25, 0.25, 0.3)
SIZE = 260  # pixels of a tile
THREE_VIEWS = ("front", "left", "three_quarter")


def edges(rig: Rig, vertices: np.ndarray) -> Paint:
    """Draws the triangles' edges."""
    search = ClosestPointSearch(vertices, rig.faces)

    def paint(colours: Reals, places: Array, _normals: Reals, _pixels: Array, pixel: float) -> Reals:
        on = search.query(places).on_mesh
        a, b, c = np.moveaxis(vertices[rig.faces[on.faces]], 1, 0)
        sides = np.stack([np.linalg.norm(side, axis=1) for side in (c - b, a - c, b - a)], axis=1)
        heights = np.linalg.norm(np.cross(b - a, c - a), axis=1)[:, None] / sides
        share = np.clip(1.0 - (on.barycentric * heights).min(axis=1) / pixel, 0.0, 0.8)[:, None]
        return np.asarray(colours + share * (np.array(EDGE) - colours))

    return paint


def tile(rig: Rig, vertices: np.ndarray, view: str, paint: Paint | None = None) -> Image.Image:
    """One picture with the template's framing, so that tiles can be compared."""
    framed = camera(view, rig.template, margin=0.08)
    framed = Camera(framed.centre, framed.axes, 0.56)
    return Image.fromarray(Scene([Layer(vertices, rig.faces)]).render(framed, (SIZE, SIZE), paint=paint))


def sheet(rows: list[tuple[str, list[Image.Image]]], path: Path) -> None:
    """Rows of tiles with a caption each."""
    width = max(sum(image.width for image in images) for _, images in rows)
    picture = Image.new("RGB", (width, sum(images[0].height for _, images in rows)), "white")
    top = 0
    for caption, images in rows:
        left = 0
        for image in images:
            picture.paste(image, (left, top))
            left += image.width
        ImageDraw.Draw(picture).text((6, top + 4), caption, fill=(20, 20, 20))
        top += images[0].height
    picture.save(path)


def extremes(rig: Rig) -> list[tuple[str, RigParameters]]:
    """Poses and scales at the edge of what patients show."""
    rest = rest_parameters(rig)
    names = rig.bone_names

    def turned(changes: dict[str, tuple[int, int, int]]) -> RigParameters:
        """Each named bone and all below it turned about its joint by a rotation vector in body axes (degrees)."""
        rotations, translations = rest.rotations.copy(), rest.translations.copy()
        for name, vector in changes.items():
            turn = exp_so3(np.radians(np.array(vector)))
            joint = next(j for j in rig.joints if names[j.child] == name)
            below = [names.index(name)]
            for index, bone in enumerate(rig.bones):
                if bone.parent in below:
                    below.append(index)
            for index in below:
                rotations[index] = turn @ rotations[index]
                translations[index] = joint.anchor + turn @ (translations[index] - joint.anchor)
        return RigParameters(rotations, translations, rest.scales, rest.weights)

    def scaled(name: str, scale: tuple[float, float, float]) -> RigParameters:
        scales = rest.scales.copy()
        scales[names.index(name)] = scale
        return RigParameters(rest.rotations, rest.translations, scales, rest.weights)

    raised = {
        "shoulder_L": (0, 0, 20),
        "shoulder_R": (0, 0, -20),
        "upper_arm_L": (0, 0, 60),
        "upper_arm_R": (0, 0, -60),
    }
    return [
        ("arms down 40", turned({"upper_arm_L": (0, 0, -40), "upper_arm_R": (0, 0, 40)})),
        ("arms out 45", turned({"upper_arm_L": (0, 0, 45), "upper_arm_R": (0, 0, -45)})),
        ("arms forward 40", turned({"upper_arm_L": (-40, 0, 0), "upper_arm_R": (-40, 0, 0)})),
        ("arms up 80", turned(raised)),
        ("shoulders up 15", turned({"shoulder_L": (0, 0, 15), "shoulder_R": (0, 0, -15)})),
        ("shoulders forward 15", turned({"shoulder_L": (0, -15, 0), "shoulder_R": (0, 15, 0)})),
        ("bent back 20", turned({"lumbar": (-10, 0, 0), "lower_thorax": (-10, 0, 0)})),
        ("bent sideways 24", turned({"lumbar": (0, 0, 12), "lower_thorax": (0, 0, 12)})),
        ("lower thorax 1.2", scaled("lower_thorax", (1.2, 1.2, 1.2))),
        ("upper thorax 0.85", scaled("upper_thorax", (0.85, 1.0, 0.85))),
        ("lumbar 0.8", scaled("lumbar", (0.8, 1.0, 0.8))),
        ("pelvis 1.2", scaled("pelvis", (1.2, 1.0, 1.2))),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description="Draws the model for inspection.")
    parser.add_argument("-o", "--out", type=Path, required=True)
    parser.add_argument("--model", type=Path, default=HERE / "built" / "torso.glb")
    arguments = parser.parse_args()
    rig = read_rig(arguments.model)
    arguments.out.mkdir(parents=True, exist_ok=True)
    views = ("front", "three_quarter", "left", "back")
    wires = edges(rig, rig.template)
    sheet(
        [
            ("template", [tile(rig, rig.template, view) for view in views]),
            ("triangles", [tile(rig, rig.template, view, wires) for view in views]),
        ],
        arguments.out / "template.png",
    )
    rows = []
    for index, shape in enumerate(rig.shapes):
        if shape.name.endswith("_R"):
            continue
        images = []
        for weight in (1.0, shape.min if shape.min < 0 else shape.max):
            weights = np.zeros(len(rig.shapes))
            weights[index] = weight
            images += [tile(rig, shaped(rig, weights), view) for view in THREE_VIEWS]
        rows.append((f"{shape.name}   1 | {shape.min if shape.min < 0 else shape.max:g}", images))
    per_sheet = 10
    for start in range(0, len(rows), per_sheet):
        sheet(rows[start : start + per_sheet], arguments.out / f"shapes_{start // per_sheet + 1}.png")
    posed = [(name, [tile(rig, pose(rig, x), view) for view in (*THREE_VIEWS, "back")]) for name, x in extremes(rig)]
    sheet(posed, arguments.out / "poses.png")
    for drawing in rig.drawings:
        lines = [
            Line(shape.points.positions(rig.template, rig.faces), _rgb(shape.color), closed=shape.closed)
            for shape in drawing.shapes
        ]
        images = []
        for view in views:
            framed = camera(view, rig.template)
            images.append(Image.fromarray(Scene([Layer(rig.template, rig.faces)]).render(framed, (480, 480), lines)))
        sheet([(drawing.name, images)], arguments.out / f"drawing_{drawing.name}.png")
    print(f"Pictures stand in {arguments.out}.")


def _rgb(colour: str) -> tuple[float, float, float]:
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


if __name__ == "__main__":
    main()
