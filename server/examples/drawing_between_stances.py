"""A drawing carried between stances: made on the standing patient, shown on the lying one, and the way back.

    python drawing_between_stances.py standing.ply supine.ply drawing_on_supine.json [landmarks.json landmarks.json]

The drawing here is a circle of the surgeon's own around the left nipple; without `drawing` it is the fit's.
"""

import sys

import numpy as np

import breastrig


def main(standing_scan: str, supine_scan: str, result: str, *landmarks: str) -> None:
    picked = landmarks or (None, None)
    standing = breastrig.fit(standing_scan, picked[0], stance="standing")
    supine = breastrig.fit(supine_scan, picked[1], stance="supine")

    there = breastrig.transfer(standing, supine, [own_circle(standing, radius_mm=40.0)])
    there.save(result)
    for line in there.lines:
        print(line, f"in {there.unit} of the lying scan")
        print(
            f"  the fits are {np.nanmean(line.distance_from_mm):.1f} and {np.nanmean(line.distance_to_mm):.1f} mm off"
        )

    (carried,) = there.lines
    here = [breastrig.Line(carried.name, carried.points, carried.closed, bridged=carried.bridged)]
    (back,) = breastrig.transfer(supine, standing, here).lines
    gap = np.linalg.norm(back.points[:, None] - own_circle(standing, 40.0).points[None], axis=2).min(axis=0)
    print(
        f"  carried there and back it is {1e3 * standing.metres_per_unit * gap.mean():.1f} mm from where it was drawn"
    )


def own_circle(fit: breastrig.Fit, radius_mm: float) -> breastrig.Line:
    """The vertices of the scan that are about this far from the left nipple, in order around it."""
    nipple = fit.landmarks["nipple_L"]
    radius = 1e-3 * radius_mm / fit.metres_per_unit  # in the scan's unit
    away = fit.scan_vertices - nipple
    ring = away[np.abs(np.linalg.norm(away, axis=1) - radius) < 0.03 * radius]
    up = fit.landmarks["suprasternal_notch"] - fit.landmarks["umbilicus"]
    left = fit.landmarks["acromion_L"] - fit.landmarks["acromion_R"]
    turn = np.arctan2(ring @ up / np.linalg.norm(up), ring @ left / np.linalg.norm(left))
    around = [ring[np.abs(turn - angle).argmin()] for angle in np.linspace(-np.pi, np.pi, 24, endpoint=False)]
    return breastrig.Line("circle", nipple + np.array(around), closed=True, color="#2040c0")


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except breastrig.BreastRigError as error:
        sys.exit(str(error))
