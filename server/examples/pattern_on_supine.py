"""A Wise pattern on the lying patient.

A reduction pattern is drawn on the standing scan, by its numbers in mm, and transferred to the lying one.
Each point of a transferred line says how far off it may be (`error_mm`, 90 %).
"""

import numpy as np
from PIL import Image

import breastrig


def main() -> Image.Image:
    standing = breastrig.fit(*breastrig.example("standing"))
    supine = breastrig.fit(*breastrig.example("supine"))

    pattern = breastrig.draw(standing, "reduction:areola_mm=42")
    there = breastrig.transfer(standing, supine, pattern)
    for line in there.lines:
        print(f"{line.name:14s} {len(line.points):4d} points, ± {np.nanmedian(line.error_mm):.1f} mm (90 %)")

    picture = Image.new("RGB", (960, 560))
    picture.paste(standing.picture(show="scan", drawing=pattern), (0, 0))
    picture.paste(supine.picture(show="scan", drawing=there), (480, 0))
    return picture


if __name__ == "__main__":
    main().save("pattern_on_supine.png")
