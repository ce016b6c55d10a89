"""How skin moves on the mean when a woman lies down, beyond the rigid motion of her trunk: data beside the rig.

The arms go up and the breasts sink outwards in everybody, and where no landmark is picked (the outer side, the upper
pole) nothing else tells.  The data are of virtual bodies whose skin is known in both stances, of two ways of computing
how a body lies down (breastrig_studies/lying_motion.py): no person's body is in them.  They stand at places of
the torso's template, so that any number of vertices will do; rigs without such a file expect no motion.  All of these
bodies lie with their arms out (54 to 79 degrees from the trunk); of women who lie with hanging arms nothing is known.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, model_validator

from breastrig.core.arrays import Array
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig

SCHEMA = "breastrig/lying-motion@1"
WIDTH = 0.02  # m, of the Gaussian that blends the places' motions; they are this far apart
BEYOND = 0.1  # of the weight of one place: where there is less, the motion dies out


@dataclass(frozen=True, eq=False)
class LyingMotion:
    """N places of a template's left side; the right side moves alike, mirrored."""

    places: Array  # (N, 3) m
    moves: Array  # (N, 3) m along the body's axes: its left, up, front

    def at(self, template: Array) -> Array:
        """(V, 3) m: the motions of a template's (V, 3) m vertices."""
        sides = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
        places = (self.places * sides[:, None]).reshape(-1, 3)
        moves = (self.moves * sides[:, None]).reshape(-1, 3)
        squares = (template**2).sum(axis=1)[:, None] + (places**2).sum(axis=1) - 2.0 * template @ places.T
        weights = np.exp(-0.5 / WIDTH**2 * squares)
        return np.asarray(weights @ moves / np.maximum(weights.sum(axis=1), BEYOND)[:, None])


class _File(BaseModel):
    schema_: Literal["breastrig/lying-motion@1"] = Field(alias="schema")
    places_mm: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]
    moves_mm: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]

    @model_validator(mode="after")
    def _fits_together(self) -> "_File":
        if len(self.places_mm) != len(self.moves_mm):
            raise ValueError("it needs one move for each place")
        return self


@lru_cache(maxsize=8)
def lying_motion(rig: Rig) -> Array | None:
    """(V, 3) m along the body's axes, of the rig's vertices; None for a rig of which nothing is known."""
    stored = known_part(rig, "lying_motion.json", _File)
    if stored is None:
        return None
    return LyingMotion(1e-3 * np.array(stored.places_mm), 1e-3 * np.array(stored.moves_mm)).at(rig.template)
