"""Landmarks: proposed, then checked.

The program proposes landmarks, a person confirms some of them. A confirmed place is given to `fit` as a
point. The bars show the 90 % radius of every landmark without any confirmed one, and with three.
"""

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

import breastrig

CONFIRMED = ("nipple_L", "nipple_R", "suprasternal_notch")


def main() -> Figure:
    example = breastrig.example("standing")
    scan = breastrig.read_scan(example.scan)
    proposals = breastrig.propose_landmarks(scan)
    for name, proposal in proposals.items():
        print(f"{name:22s} {np.round(proposal.point, 3)} confidence {proposal.confidence:.2f}")
    for name, reason in proposals.not_proposed.items():
        print(f"{name:22s} not proposed: {reason}")

    before = breastrig.fit(scan)
    known = breastrig.fit(scan, example.landmarks).picked  # what a person would click on
    after = breastrig.fit(scan, {name: known[name] for name in CONFIRMED})

    names = list(before.landmark_radii)
    mm = 1e3 * before.metres_per_unit
    figure, axis = plt.subplots(figsize=(7, 4), layout="constrained")
    rows = np.arange(len(names))
    axis.barh(rows - 0.2, [mm * before.landmark_radii[name] for name in names], 0.4, label="nothing confirmed")
    axis.barh(rows + 0.2, [mm * after.landmark_radii[name] for name in names], 0.4, label="three confirmed")
    axis.set_yticks(rows, names)
    axis.set_xlabel("90 % radius (mm)")
    axis.legend()
    return figure


if __name__ == "__main__":
    main().savefig("landmarks_checked.png")
