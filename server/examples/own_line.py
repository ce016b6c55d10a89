"""A line of your own.

Rough places become a line along the skin (`project`). It is carried to the lying scan and back; the program
prints how far it ends from where it began.
"""

import numpy as np
from PIL import Image

import breastrig


def main() -> Image.Image:
    standing = breastrig.fit(*breastrig.example("standing"))
    supine = breastrig.fit(*breastrig.example("supine"))

    own = breastrig.project(standing, circle(standing, "nipple_L", 40.0), "my circle", closed=True, color="#2040c0")
    there = breastrig.transfer(standing, supine, own)
    [carried] = there.lines
    print(carried, f"± {np.nanmedian(carried.error_mm):.1f} mm (90 %)")

    [back] = breastrig.transfer(supine, standing, carried).lines
    apart = np.linalg.norm(back.points[:, None] - own.points[None], axis=2).min(axis=1)
    print(f"there and back it ends {1e3 * standing.metres_per_unit * apart.mean():.1f} mm from where it began")

    picture = Image.new("RGB", (960, 560))
    picture.paste(standing.picture("three_quarter", show="scan", drawing=breastrig.draw(standing, own)), (0, 0))
    picture.paste(supine.picture("three_quarter", show="scan", drawing=there), (480, 0))
    return picture


def circle(fit: breastrig.Fit, landmark: str, radius_mm: float) -> np.ndarray:
    """(12, 3) rough places around a landmark, as seen from the front."""
    turns = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)[:, None]
    radius = 1e-3 * radius_mm / fit.metres_per_unit  # in the scan's unit
    return fit.landmarks[landmark] + radius * (np.cos(turns) * fit.frame.left + np.sin(turns) * fit.frame.up)


if __name__ == "__main__":
    main().save("own_line.png")
