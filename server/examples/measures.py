"""Measures of both breasts.

Every measure of the report, with its 90 % interval, and left less right. The bars show the lengths of both
sides.
"""

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

import breastrig


def main() -> Figure:
    fit = breastrig.fit(*breastrig.example("standing"))
    rows = breastrig.measure(fit)
    for row in rows:
        if row.value is not None or "value" in row.not_seen:
            print(f"{row.label:30s} {row.kind:14s} {text(row.value, 2 if row.kind == 'ratio' else 1)} {row.unit}")
            continue
        less = "" if row.difference is None else f"L - R {row.difference:+.1f} ± {row.difference_margin or np.nan:.1f}"
        print(f"{row.label:30s} {row.kind:14s} L {text(row.left):20s} R {text(row.right):20s} {less} {row.unit}")

    shown = [row for row in rows if row.kind == "straight" and row.left is not None and row.right is not None]
    figure, axis = plt.subplots(figsize=(8, 4), layout="constrained")
    for shift, side in ((-0.2, "left"), (0.2, "right")):
        numbers = [getattr(row, side) for row in shown]
        reach = [0.0 if each.low is None else each.value - each.low for each in numbers]
        places = np.arange(len(shown)) + shift
        axis.barh(places, [each.value for each in numbers], 0.4, xerr=reach, label=side)
    axis.set_yticks(np.arange(len(shown)), [row.label for row in shown])
    axis.set_xlabel("mm, with the 90 % interval")
    axis.legend()
    return figure


def text(number: breastrig.Number | None, digits: int = 1) -> str:
    if number is None:
        return "not seen"
    band = "" if number.low is None else f" ({number.low:.{digits - 1}f} to {number.high:.{digits - 1}f})"
    return f"{number.value:.{digits}f}{band}"


if __name__ == "__main__":
    main().savefig("measures.png")
