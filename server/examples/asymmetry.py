"""Asymmetry map.

The left half of the body, mirrored on its median plane and compared with the right one: how many mm each
place of the skin stands out beyond its counterpart (orange) or stays behind it (blue).
"""

import numpy as np
from matplotlib import colormaps
from PIL import Image

import breastrig


def main() -> Image.Image:
    fit = breastrig.fit(*breastrig.example("standing"))
    counterpart = fit.frame.mirrored(fit.vertices)[fit.model.mirror_vertices]
    outwards = fit.to_trimesh().vertex_normals
    mm = 1e3 * fit.metres_per_unit * np.einsum("vi,vi->v", fit.vertices - counterpart, outwards)
    for side in ("L", "R"):
        breast = fit.model.regions[f"breast_{side}"]
        print(f"breast_{side}: {mm[breast].mean():+.1f} mm on average, up to {np.abs(mm[breast]).max():.1f} mm")

    colours = colormaps["PuOr_r"](0.5 + mm / 20.0)[:, :3]  # ± 10 mm
    picture = Image.new("RGB", (960, 560))
    for place, view in enumerate(("front", "three_quarter")):
        picture.paste(
            fit.model.picture(fit.vertices, unit=fit.unit, view=view, colours=colours, size=(480, 560)),
            (480 * place, 0),
        )
    return picture


if __name__ == "__main__":
    main().save("asymmetry.png")
