"""Predicted and true supine.

The lying patient is predicted from the standing scan, and compared with the real lying scan. Both are brought
into one frame by the trunk, so that what is left is what gravity does.
"""

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

import breastrig

TRUNK = ("suprasternal_notch", "mid_sternum", "xiphoid", "midclavicle_L", "midclavicle_R", "umbilicus")


def main() -> Image.Image:
    standing = breastrig.fit(*breastrig.example("standing"))
    supine = breastrig.fit(*breastrig.example("supine"))
    predicted = breastrig.predict(standing, "supine")

    moved = aligned(predicted, supine)
    mm = 1e3 * supine.metres_per_unit
    for name, place in moved.items():
        off = mm * np.linalg.norm(place - supine.landmarks[name])
        stated = 1e3 * predicted.metres_per_unit * predicted.landmark_radii[name]
        print(f"{name:22s} {off:5.1f} mm off, ± {stated:.0f} mm stated (90 %)")

    picture = Image.new("RGB", (1440, 560))
    for place, fit in enumerate((standing, predicted, supine)):
        picture.paste(fit.picture("three_quarter", show="model"), (480 * place, 0))
    return picture


def aligned(moving: breastrig.Fit, fixed: breastrig.Fit) -> dict[str, np.ndarray]:
    """The landmarks of one fit in the frame and unit of another, whose trunk they fit best."""
    scale = moving.metres_per_unit / fixed.metres_per_unit
    there = np.array([scale * moving.landmarks[name] for name in TRUNK])
    here = np.array([fixed.landmarks[name] for name in TRUNK])
    turn, _ = Rotation.align_vectors(here - here.mean(axis=0), there - there.mean(axis=0))
    return {
        name: turn.apply(scale * place - there.mean(axis=0)) + here.mean(axis=0)
        for name, place in moving.landmarks.items()
    }


if __name__ == "__main__":
    main().save("prediction.png")
