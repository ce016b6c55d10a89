"""Remaining uncertainty of a fit.

A hundred bodies drawn from the posterior of a fit, and the scatter of each vertex among them, beside the
calibrated 90 % radius that the fit states.
"""

import numpy as np
from matplotlib import colormaps
from PIL import Image

import breastrig


def main() -> Image.Image:
    fit = breastrig.fit(breastrig.example("standing").scan)  # without landmarks: much is left open
    known = fit.posterior
    print(f"{len(known.mean)} unknowns in {len(known.blocks)} blocks, as {', '.join(list(known.blocks)[:4])}")
    rng = np.random.default_rng(2)
    bodies = np.stack([fit.model.pose(known.sample(rng)) for _ in range(100)]) / fit.metres_per_unit
    spread = np.quantile(np.linalg.norm(bodies - bodies.mean(axis=0), axis=2), 0.9, axis=0)
    mm = 1e3 * fit.metres_per_unit
    print(f"90 % of draws within {mm * np.median(spread):.1f} mm; stated {mm * np.nanmedian(fit.uncertainty):.1f} mm")

    picture = Image.new("RGB", (960, 560))
    for place, radii in enumerate((spread, fit.uncertainty)):
        colours = colormaps["magma_r"](np.nan_to_num(mm * radii) / 25.0)[:, :3]
        picture.paste(
            fit.model.picture(fit.vertices, unit=fit.unit, colours=colours, size=(480, 560)), (480 * place, 0)
        )
    return picture


if __name__ == "__main__":
    main().save("posterior.png")
