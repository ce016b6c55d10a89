"""Bend the model by name.

A fit's pose and shape are a value with names. One blendshape is changed with `dataclasses.replace`, and
`model.pose` gives the body: here the left breast, smaller and larger than the patient's.
"""

from dataclasses import replace

import numpy as np
from PIL import Image

import breastrig

SHAPE = "projection_L"


def main() -> Image.Image:
    fit = breastrig.fit(*breastrig.example("standing"))
    own = fit.parameters
    print(f"{len(own.bones)} bones, {len(own.blendshapes)} shapes; {SHAPE} is {own.blendshapes[SHAPE]:.2f}")

    picture = Image.new("RGB", (1500, 360))
    for place, change in enumerate(np.linspace(-2.0, 2.0, 5)):
        changed = replace(own, blendshapes={**own.blendshapes, SHAPE: own.blendshapes[SHAPE] + change})
        body = fit.model.pose(changed)
        moved = 1e3 * fit.metres_per_unit * np.linalg.norm(body - fit.vertices, axis=1).max()
        print(f"{change:+.1f}: the skin moves by up to {moved:.0f} mm")
        picture.paste(fit.model.picture(body, unit=fit.unit, view="three_quarter"), (300 * place, 0))
    return picture


if __name__ == "__main__":
    main().save("shape_by_name.png")
