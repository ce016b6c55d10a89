"""A fit's progress bar."""

import sys
from collections.abc import Iterator

from breastrig.cli.interruption import raise_if_asked
from breastrig.use.fit import FitRun, Iterate, Step
from breastrig.use.values.fit_result import Fit


def fitted(run: FitRun[Step, Fit], quiet: bool = False) -> Fit:
    """The run's result, with a bar on a terminal unless it is `quiet`; KeyboardInterrupt where a signal came."""
    for _ in run if quiet or not sys.stderr.isatty() else _with_bar(run):
        raise_if_asked()
    return run.result()


def _with_bar(run: FitRun[Step, Fit]) -> Iterator[Step]:
    from tqdm import tqdm  # programs and scripts see no bar

    with tqdm(total=run.iterations_limit, unit="step", leave=False) as bar:
        for step in run:
            bar.update()
            if isinstance(step, Iterate):
                bar.set_postfix_str(f"{step.stage}, {step.mean_distance_mm:.2f} mm")
            yield step
