"""The expected motion of the skin between standing and supine beyond the trunk's rigid motion, and its variation.

The arms go up and the breasts sink outwards in everybody, more or less. Where no landmark is placed (the outer side,
the upper pole) there is no other information. The data, beside the rig, are of virtual bodies whose skin is known in
both stances, of two ways of computing how a body lies down (breastrig_studies/lying_motion.py): no person's body is in
them. They are given at places of the torso's template, so that any number of vertices will do; rigs without such a file
expect no motion. The bodies of the mean lie with their arms out (54 to 79 degrees from the trunk), those of the
variation also with hanging ones.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, model_validator

from breastrig.core.arrays import Array
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig

SCHEMA = "breastrig/lying-motion@2"
WIDTH = 0.02  # m, of the Gaussian that blends the places' motions; they are this far apart
BEYOND = 0.1  # of the weight of one place: where there is less, the motion dies out


@dataclass(frozen=True, eq=False)
class Motions:
    """K motions at N places of a template's left side; on the right side each is its mirror image, or that reversed."""

    places: Array  # (N, 3) m
    moves: Array  # (K, N, 3) m along the patient's left, up and front
    signs: Array  # (K,) 1 where both sides move alike, -1 where one does the reverse of the other

    def at(self, template: Array) -> Array:
        """(K, V, 3) m: the motions of a template's (V, 3) m vertices."""
        mirror = np.array([-1.0, 1.0, 1.0])
        places = np.concatenate([self.places, self.places * mirror])
        moves = np.concatenate([self.moves, self.signs[:, None, None] * self.moves * mirror], axis=1)
        squares = (template**2).sum(axis=1)[:, None] + (places**2).sum(axis=1) - 2.0 * template @ places.T
        weights = np.exp(-0.5 / WIDTH**2 * squares)
        return np.asarray(weights @ moves / np.maximum(weights.sum(axis=1), BEYOND)[:, None])


class _Motions(BaseModel):
    places_mm: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]
    moves_mm: Annotated[list[list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]], Field(min_length=1)]
    signs: list[Literal[1, -1]]

    @model_validator(mode="after")
    def _fits_together(self) -> "_Motions":
        if {len(moves) for moves in self.moves_mm} != {len(self.places_mm)} or len(self.signs) != len(self.moves_mm):
            raise ValueError("each motion needs a move for each place, and a sign")
        return self

    def at(self, template: Array) -> Array:
        """(K, V, 3) m: the motions of a template's (V, 3) m vertices."""
        places, moves = 1e-3 * np.array(self.places_mm), 1e-3 * np.array(self.moves_mm)
        return Motions(places, moves, np.array(self.signs, dtype=np.float64)).at(template)


class _File(BaseModel):
    schema_: Literal["breastrig/lying-motion@2"] = Field(alias="schema")
    mean: _Motions
    ways: _Motions  # standard deviations in which women differ from the mean


@lru_cache(maxsize=8)
def lying_motion(rig: Rig) -> Array | None:
    """(1 + K, V, 3) m of the rig's vertices along the body's axes: the mean, and K modes of variation between patients,
    each one standard deviation. None for a rig without such data."""
    stored = known_part(rig, "lying_motion.json", _File)
    if stored is None:
        return None
    return np.concatenate([stored.mean.at(rig.template)[:1], stored.ways.at(rig.template)])
