"""One fit, watched and drawn: how the model settles, and how far it ends from the scan.

python fit_with_plot.py scan.ply landmarks.json fit.png          (needs pip install "breastrig[plots]")
"""

import sys

import matplotlib
import numpy as np

import breastrig

matplotlib.use("Agg")
from matplotlib import pyplot as plt


def main(scan_file: str, landmark_file: str, picture: str) -> None:
    scan = breastrig.read_scan(scan_file)
    print(scan, scan.unit_reason)
    run = breastrig.iterates(scan, landmark_file)
    steps = list(run)  # each with its vertices; leaving the loop would cancel the fit
    fit = run.result()
    print(fit, *fit.verdict.reasons)

    across, up = seen_from_the_front(fit)
    mm = 1e3 * fit.metres_per_unit * fit.distances  # nan where the scan shows nothing
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 5), layout="constrained")
    left.plot([step.iteration for step in steps], [step.mean_distance_mm for step in steps], "o-")
    left.set(xlabel="iteration", ylabel="mean distance to the scan (mm)", title=f"{fit.stance}, {fit.verdict.level}")
    dots = right.scatter(across, up, c=mm, s=4, cmap="coolwarm", vmin=-3.0, vmax=3.0, plotnonfinite=True)
    figure.colorbar(dots, label="model outside the scan (mm)")
    for line in fit.drawing.lines:
        right.plot(*seen_from_the_front(fit, line.points), color="black", linewidth=1)
    right.set(aspect="equal", title="Research use only")
    right.axis("off")
    figure.savefig(picture, dpi=120)


def seen_from_the_front(fit: breastrig.Fit, points: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Places (M, 3) in the scan's frame, by default the model's, along two axes of the body: to her left, and up."""
    notch = fit.landmarks["suprasternal_notch"]
    left = fit.landmarks["acromion_L"] - fit.landmarks["acromion_R"]
    up = notch - fit.landmarks["umbilicus"]
    left, up = left / np.linalg.norm(left), up / np.linalg.norm(up)
    places = (fit.vertices if points is None else points) - notch
    return places @ left, places @ up


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except breastrig.BreastRigError as error:  # one sentence: what is wrong, and what to do
        sys.exit(str(error))
