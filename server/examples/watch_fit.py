"""Watch the solver.

`breastrig.iterates` is the same fit step by step. Each iterate has the whole model, so a program can draw it,
log it, or stop. The picture shows every second iterate, and how the distance to the scan falls.
"""

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

import breastrig


def main() -> Figure:
    run = breastrig.iterates(*breastrig.example("standing"))
    steps = list(run)  # leaving the loop early would cancel the fit
    fit = run.result()
    for step in steps:
        print(step)
    print(fit)

    shown = steps[::2]
    figure, axes = plt.subplots(1, len(shown) + 1, figsize=(2.0 * len(shown) + 3, 3), layout="constrained")
    for axis, step in zip(axes, shown, strict=False):
        axis.imshow(fit.model.picture(step.vertices, unit=fit.unit, view="three_quarter"))
        axis.set_title(f"{step.iteration}: {step.stage}")
        axis.axis("off")
    axes[-1].plot([step.iteration for step in steps], [step.mean_distance_mm for step in steps], "o-")
    axes[-1].set(xlabel="iteration", ylabel="mean distance to the scan (mm)")
    return figure


if __name__ == "__main__":
    main().savefig("watch_fit.png")
