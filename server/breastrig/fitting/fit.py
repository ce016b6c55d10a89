"""The registration: match, build the terms, one damped Newton step, yield; stage after stage.

A generator of frozen iterates is the only way to run a fit: the command line, the service and the tests all
consume it, and whoever stops consuming cancels the fit.  Nothing here prints, stores or draws.
"""

from collections.abc import Iterator

import numpy as np

from breastrig.fitting.bounds import allowed_start, free_unknowns, step_bounds
from breastrig.fitting.stance_fit import StanceFit, Stillness, mean_distance, stage_progress
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status, newton_step

__all__ = ["FitIterate", "FitTask", "fit_iterates"]


def fit_iterates(task: FitTask) -> Iterator[FitIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped."""
    recipe, fit, stillness = task.recipe, StanceFit(task), Stillness(task.recipe.stop)
    x, energy, iteration = allowed_start(task), np.nan, 0
    for stage in recipe.stages:
        free = free_unknowns(task, stage, x.dof)
        last_stage = stage is recipe.stages[-1]
        stillness.new_stage()
        damping = recipe.damping
        for step_number in range(stage.iterations):
            progress = stage_progress(stage, step_number)
            matches = fit.matches(stage, progress, x)
            still = stillness.reached(mean_distance(matches, np.inf), progress)
            if last_stage and still:
                yield fit.iterate(iteration, stage, x, energy, matches, Status.CONVERGED)
                return
            if fit.lost(matches):
                yield fit.iterate(iteration, stage, x, energy, matches, Status.STALLED)
                return
            yield fit.iterate(iteration, stage, x, energy, matches, Status.RUNNING)
            step = newton_step(
                fit.terms(stage, progress, x, matches),
                fit.held,
                x,
                scaling=fit.scaling,
                damping=damping,
                least_damping=recipe.damping,
                bounds=step_bounds(task, x),
                free=free,
            )
            if step.status is Status.NOT_FINITE:
                yield fit.iterate(iteration, stage, x, energy, matches, Status.NOT_FINITE)
                return
            x, energy, damping = step.x, step.energy, step.damping
            iteration += 1
            if step.status is Status.STALLED and last_stage:
                yield fit.iterate(iteration, stage, x, energy, matches, Status.STALLED)
                return
    yield fit.iterate(iteration, stage, x, energy, fit.matches(stage, 1.0, x), Status.OUT_OF_ITERATIONS)
