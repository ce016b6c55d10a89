"""volume.json of a rig: its chest wall and tetrahedra at rest, found by its hash (model_assets/make_volume.py)."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, NonNegativeInt

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput, BadModel
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig
from breastrig.volume.bare_chest import BareChest
from breastrig.volume.volume_mesh import REGIONS, outer_triangles

FILE = "volume.json"
NONE = "Nothing is known of the inside of the rig {name}: there is no {name}.known/volume.json of it."

Place = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
Four = Annotated[list[NonNegativeInt], Field(min_length=4, max_length=4)]


class _Chest(BaseModel):
    under: list[NonNegativeInt]
    share: list[FiniteFloat]
    around: list[NonNegativeInt]
    weights: list[list[FiniteFloat]]


class _File(BaseModel):
    schema_: Literal["breastrig/volume@2"] = Field(alias="schema")
    points: list[Place]
    chest: _Chest
    tetrahedra: list[Four]
    regions: list[Annotated[int, Field(ge=0, lt=len(REGIONS))]]
    attachments: dict[str, list[NonNegativeInt]]


@dataclass(frozen=True, eq=False)
class KnownVolume:
    """The rest state: N nodes, the first V are the rig's vertices, the next V lie under them on the chest wall."""

    points: Array  # (N, 3) m
    chest: BareChest
    tetrahedra: Integers  # (M, 4)
    regions: Integers  # (M,)
    cuts: Integers  # (C, 3) triangles where the body was cut off
    attachments: dict[str, Integers]  # vertices of the wall


@lru_cache(maxsize=4)
def known_volume(rig: Rig) -> KnownVolume:
    """The rig's volume data; BadInput for a rig without them, BadModel for a damaged file."""
    found = known_part(rig, FILE, _File)
    if found is None:
        raise BadInput(NONE.format(name=rig.name))
    count = len(rig.template)
    points = np.concatenate([rig.template, np.array(found.points).reshape(-1, 3)])
    tetrahedra = np.array(found.tetrahedra, dtype=np.int64).reshape(-1, 4)
    attachments = {name: np.array(members, dtype=np.int64) for name, members in found.attachments.items()}
    chest = BareChest(**{name: np.array(values) for name, values in found.chest})
    of_skin = [*attachments.values(), chest.under, chest.around]
    named = [(tetrahedra, len(points)), *((members, count) for members in of_skin)]
    if (
        len(points) < 2 * count
        or chest.weights.shape != (len(chest.under), len(chest.around))
        or chest.share.shape != chest.under.shape
        or len(found.regions) != len(tetrahedra)
        or any(members.max(initial=-1) >= limit for members, limit in named)
        or not np.array_equal(np.unique(tetrahedra), np.arange(len(points)))
    ):
        raise BadModel(f"{rig.name}.known/{FILE} does not belong to this rig; mend it or take it away.")
    return KnownVolume(
        points=points,
        chest=chest,
        tetrahedra=tetrahedra,
        regions=np.array(found.regions, dtype=np.int64),
        cuts=_without(outer_triangles(tetrahedra), rig.faces),
        attachments=attachments,
    )


def _without(triangles: Integers, others: Integers) -> Integers:
    """The triangles that are not among the others."""
    ours, theirs = (np.sort(each, axis=1) for each in (triangles, others))
    known = {tuple(row) for row in theirs.tolist()}
    return triangles[[tuple(row) not in known for row in ours.tolist()]]
