"""A lesion from its centre.

A ball inside the body, known from an image, is placed in the standing scan: how deep it lies, how far it is
from nipple, chest wall and the planned line, each with its 90 % band. Then it is transferred through the
tissue to the lying scan.
"""

from PIL import Image

import breastrig


def main() -> Image.Image:
    standing = breastrig.fit(*breastrig.example("standing"))
    supine = breastrig.fit(*breastrig.example("supine"))

    in_unit = 1e-3 / standing.metres_per_unit  # mm in the scan's unit
    center = standing.landmarks["nipple_L"] - 30.0 * in_unit * standing.frame.front
    plan = [breastrig.Lesion("Lesion 1", center, radius_mm=7.0), standing.drawing.lines[0]]
    here = breastrig.draw(standing, plan)
    there = breastrig.transfer(standing, supine, here)
    for place, drawing in (("standing", here), ("supine", there)):
        [lesion] = drawing.lesions
        print(f"{place}: centre ± {lesion.error_mm:.1f} mm, {lesion.depth_mm:.1f} mm under the skin")
        for to, (mm, low, high) in lesion.distances_mm.items():
            print(f"  {mm:5.1f} mm ({low:.0f} to {high:.0f}) to {to}")

    picture = Image.new("RGB", (960, 560))
    picture.paste(standing.picture(show="scan", drawing=here), (0, 0))
    picture.paste(supine.picture(show="scan", drawing=there), (480, 0))
    return picture


if __name__ == "__main__":
    main().save("lesion.png")
