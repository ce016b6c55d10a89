"""A rig of your own.

Any skinned glTF with named shapes and a JSON side file fits without a change of code. Here the package's
second rig, the chest of a man, is fitted to a body of its own that is drawn at random and seen from the front
only.
"""

import numpy as np
from PIL import Image

import breastrig


def main() -> Image.Image:
    rig = breastrig.load_model("male")  # or the path of a .glb
    print(rig.name, len(rig.bone_names), "bones,", len(rig.shape_names), "shapes,", len(rig.landmarks), "landmarks")

    body = rig.pose(rig.sample(np.random.default_rng(5)))
    facing = np.cross(*(body[rig.faces[:, k]] - body[rig.faces[:, 0]] for k in (1, 2)))[:, 2] > 0.0
    seen = breastrig.Scan.from_arrays(body, rig.faces[facing], unit="m")  # what a camera in front would see
    landmarks = dict(
        zip(
            (landmark.name for landmark in rig.landmarks),
            rig.landmark_points(tuple(each.name for each in rig.landmarks)).positions(body, rig.faces),
            strict=True,
        )
    )

    fit = breastrig.fit(seen, landmarks, model=rig, stance="standing")
    off = 1e3 * np.linalg.norm(fit.vertices - body, axis=1)
    print(fit, *fit.verdict.reasons)
    print(f"true skin: {off.mean():.1f} mm off on average, the unseen back among it")

    picture = Image.new("RGB", (960, 560))
    picture.paste(fit.picture(show="scan"), (0, 0))
    picture.paste(fit.picture(show="uncertainty"), (480, 0))
    return picture


if __name__ == "__main__":
    main().save("own_rig.png")
