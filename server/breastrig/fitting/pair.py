"""One patient in two stances, fitted together: one body, two poses.

Each stance builds its matches and terms as in a fit of its own; their normal equations are added up in one
system in which the body stands once (shared_body.py), and one damped Newton step moves both.  Stages, stop rule
and priors are the single fit's.  The body's priors count once for each stance, as its data do, so a scan fitted
with itself gives the single fit.

Mean error in mm of points carried by the fitted models alone, there and back, over chest and breasts
(evaluation/studies/two_stances.py; exact landmarks / landmarks clicked 5 mm off):

                                              apart         ONE_BODY       ALIKE
    two independent virtual patients          7.4 /  7.6    13.5 / 13.8    6.9 / 6.8
    two of the template's origin              7.0 /  9.4    10.2 / 11.6    7.2 / 9.0
    seven others of the template's origin     6.1 /  7.3     7.3 /  7.8    6.9 / 7.7

These patients' chests are up to a quarter flatter when lying, which one body cannot show: with true correspondences
it stays 6.1 mm away, two bodies 2.3 mm.  Scans of a body that keeps its shape do gain.  Other couplings, on the
first four from standing to supine, where apart gave 7.5 / 8.4 (an earlier preset): one body 11.5 / 12.0, breast
outline apart 11.1 / 11.8, all shapes of breast and thorax apart and soft shapes alike 7.8 / 8.6, scales apart and
breast outline alike 8.1 / 8.8, everything alike to half a sigma 7.0 / 7.8, alike by the strain between the stances
7.0 / 7.9; and where apart gave 7.0 / 8.2: body alike to 1 and soft to 0.5 sigma (ALIKE) 6.8 / 7.7, body to 0.5 and
soft to 1 sigma 7.3 / 8.3, scales to 0.05 instead of 0.1 7.2 / 8.1.  What is left is sliding along the skin, which
drawings/carry.py mends: 3.3 / 5.1 over the first four, whatever the coupling.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from breastrig.core.errors import BadSettings
from breastrig.fitting.bounds import allowed_start, free_unknowns, step_bounds
from breastrig.fitting.coupling import ONE_BODY, Coupling, Springs
from breastrig.fitting.shared_body import SharedBody, TwoStances
from breastrig.fitting.stance_fit import StanceFit, Stillness, mean_distance, stage_progress
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status, Value, assemble, damped_step, value
from breastrig.least_squares.problem import ResidualTerm
from breastrig.rig.parameters import RigParameters

Terms = list[ResidualTerm[RigParameters]]


@dataclass(frozen=True, eq=False)
class PairIterate:
    """One state of both stances; the energy in each is that of the two together."""

    iteration: int  # 0 is the start
    first: FitIterate
    second: FitIterate
    status: Status  # RUNNING on all but the last


def _checked(first: FitTask, second: FitTask) -> None:
    if first.rig is not second.rig:
        raise BadSettings("Two stances are fitted together with one model; give the same model for both.")
    if first.recipe != second.recipe:
        raise BadSettings("Two stances are fitted together with one preset; give the same preset for both.")


def _value(fits: tuple[StanceFit, StanceFit], terms: tuple[Terms, Terms], springs: Springs, point: TwoStances) -> Value:
    own = value(terms[0], fits[0].held, point.first), value(terms[1], fits[1].held, point.second)
    return own[0] + own[1] + Value(springs.energy(point))


def fit_pair_iterates(first: FitTask, second: FitTask, coupling: Coupling = ONE_BODY) -> Iterator[PairIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped.

    Raises BadSettings when the tasks differ in model or preset.
    """
    _checked(first, second)
    recipe, layout = first.recipe, SharedBody(first.rig, coupling.exact)
    springs = Springs(first.rig, coupling, layout)
    fits = StanceFit(first), StanceFit(second)
    stillness = Stillness(recipe.stop), Stillness(recipe.stop)
    scaling = layout.added(fits[0].scaling, fits[1].scaling)
    state, total, iteration = layout.agreed(allowed_start(first), allowed_start(second)), np.nan, 0

    def iterate(status: Status) -> PairIterate:
        one = fits[0].iterate(iteration, stage, state.first, total, matches[0], status)
        other = fits[1].iterate(iteration, stage, state.second, total, matches[1], status)
        return PairIterate(iteration, one, other, status)

    for stage in recipe.stages:
        free = layout.free(free_unknowns(first, stage, first.start.dof))
        last_stage = stage is recipe.stages[-1]
        damping = recipe.damping
        for rule in stillness:
            rule.new_stage()
        for step_number in range(stage.iterations):
            progress = stage_progress(stage, step_number)
            matches = [
                fit.matches(stage, progress, x) for fit, x in zip(fits, (state.first, state.second), strict=True)
            ]
            still = [
                rule.reached(mean_distance(found, np.inf), progress)
                for rule, found in zip(stillness, matches, strict=True)
            ]
            if last_stage and all(still):
                yield iterate(Status.CONVERGED)
                return
            if any(fit.lost(found) for fit, found in zip(fits, matches, strict=True)):
                yield iterate(Status.STALLED)
                return
            yield iterate(Status.RUNNING)
            one = fits[0].terms(stage, progress, state.first, matches[0])
            other = fits[1].terms(stage, progress, state.second, matches[1])
            apart = assemble(one, fits[0].held, state.first), assemble(other, fits[1].held, state.second)
            step = damped_step(
                springs.added_to(layout.system(*apart), state),
                partial(_value, fits, (one, other), springs),
                state,
                scaling=scaling,
                damping=damping,
                least_damping=recipe.damping,
                bounds=layout.bounds(step_bounds(first, state.first), step_bounds(second, state.second)),
                free=free,
            )
            if step.status is Status.NOT_FINITE:
                yield iterate(Status.NOT_FINITE)
                return
            state, total, damping = step.x, step.energy, step.damping
            iteration += 1
            if step.status is Status.STALLED and last_stage:
                yield iterate(Status.STALLED)
                return
    matches = [fit.matches(stage, 1.0, x) for fit, x in zip(fits, (state.first, state.second), strict=True)]
    yield iterate(Status.OUT_OF_ITERATIONS)
