"""Leave-one-out residuals of picks, to first order, with their predictive covariance.

With the normal equations H, the rows J_i of pick i (in standard deviations) and its residual r_i

    e_i = (I − h_ii)⁻¹ r_i,    (I − h_ii)⁻¹,    h_ii = J_i H⁻¹ J_iᵀ

(the PRESS residual; Allen, The relationship between variable selection and data augmentation, 1974).  The misfit of the
model (presets, `landmarks`) and the effect of hanging breasts (body/hanging.py) are added to the covariance; the
deviation of a pick is the length of e_i in its units.
"""

from collections.abc import Collection

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.body.hanging import hanging_misfit
from breastrig.fitting.posterior import Posterior


class LeaveOneOut:
    """The picks of a fit that has some."""

    def __init__(self, posterior: Posterior) -> None:
        picks, task = posterior.picks, posterior.task
        assert picks is not None, "there are no picks to leave out"
        lin = picks.linearise(posterior.state)
        self.names = tuple(task.given)
        count = len(self.names)
        rows = lin.jacobian.reshape(3, count, -1).transpose(1, 0, 2).reshape(3 * count, -1)
        white = posterior.whitened(rows)
        self._hat: Array = white @ white.T  # (3L, 3L)
        self._residual = lin.residual.reshape(3, count).T  # (L, 3), in standard deviations as they count here
        self._unit = np.linalg.inv(picks.whitening)  # (L, 3, 3) m, of these
        self._gaps = picks.gaps(posterior.state.vertices)  # (L, 3) m
        self._own = [each.covariance for each in picks.observations]
        self._misfit = np.array([task.recipe.landmark_errors(name).misfit for name in self.names])
        self._hanging = [hanging_misfit(posterior.state, task.recipe, name) for name in self.names]

    def _left_out(self, without: Collection[str]) -> dict[str, tuple[Array, Array]]:
        """Name -> (3,) m, (3, 3) m²: see `deviations`."""
        hat, residual = self._hat, self._residual.ravel()
        gone = np.repeat([name in without for name in self.names], 3)
        if gone.any():  # Woodbury: the rows of the picks that are gone leave the normal equations
            push = np.linalg.solve(np.eye(int(gone.sum())) - hat[np.ix_(gone, gone)], np.eye(int(gone.sum())))
            residual = residual + hat[:, gone] @ push @ residual[gone]
            hat = hat + hat[:, gone] @ push @ hat[gone]
        result: dict[str, tuple[Array, Array]] = {}
        for i, name in enumerate(self.names):
            own = slice(3 * i, 3 * i + 3)
            place = hat[own, own]  # of the model's place, in the pick's sigmas
            error: Array = residual[own]
            if name not in without:
                inverse = np.linalg.inv(np.eye(3) - hat[own, own])
                place, error = inverse - np.eye(3), inverse @ error
            unit, (shift, spread) = self._unit[i], self._hanging[i]
            beside = self._own[i] + self._misfit[i] ** 2 * np.eye(3) + spread
            result[name] = (unit @ error + shift, unit @ place @ unit.T + beside)
        return result

    @property
    def distances(self) -> dict[str, float]:
        """Name -> m from the fitted model's landmark to the pick, as it was given."""
        return dict(zip(self.names, map(float, np.linalg.norm(self._gaps, axis=1)), strict=True))

    def gaps(self, without: Collection[str] = ()) -> dict[str, float]:
        """Name -> m for every pick, each left out alone, those in `without` left out all the time."""
        return {name: float(np.linalg.norm(error)) for name, (error, _) in self._left_out(without).items()}

    def deviations(self, without: Collection[str] = ()) -> dict[str, float]:
        """Name -> the gap in standard deviations of what is expected there; `without` as in `gaps`."""
        return {
            name: float(np.sqrt(error @ np.linalg.solve(expected, error)))
            for name, (error, expected) in self._left_out(without).items()
        }
