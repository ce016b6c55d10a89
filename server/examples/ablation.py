"""How many landmarks?

The error of landmarks that were not given to the fit, for 0, 3, 6 and 9 that were.
"""

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

import breastrig

COUNTS = (0, 3, 6, 9)


def main() -> Figure:
    example = breastrig.example("standing")
    scan = breastrig.read_scan(example.scan)
    true = breastrig.fit(scan, example.landmarks).picked  # (3,) each, in the scan's unit
    names = list(true)
    np.random.default_rng(0).shuffle(names)

    errors, radii = [], []
    for count in COUNTS:
        fit = breastrig.fit(scan, {name: true[name] for name in names[:count]}, drawing=None)
        left = names[max(COUNTS) :]  # never given, so that all fits answer for the same places
        mm = 1e3 * fit.metres_per_unit
        errors.append([mm * np.linalg.norm(fit.landmarks[name] - true[name]) for name in left])
        radii.append([mm * fit.landmark_radii[name] for name in left])
        print(
            f"{count} given: {np.mean(errors[-1]):.1f} mm off on average, ± {np.mean(radii[-1]):.1f} mm stated (90 %)"
        )

    figure, axis = plt.subplots(figsize=(6, 4), layout="constrained")
    axis.plot(COUNTS, np.mean(errors, axis=1), "o-", label="error")
    axis.plot(COUNTS, np.mean(radii, axis=1), "s--", label="stated 90 % radius")
    axis.set(xlabel="landmarks given", ylabel=f"mm, mean of {len(left)} others", xticks=COUNTS, ylim=(0, None))
    axis.legend()
    return figure


if __name__ == "__main__":
    main().savefig("ablation.png")
