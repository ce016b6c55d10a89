"""One warped body from a source and its numbers: both stances, corresponding, with the landmarks that are left."""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.warped.bumps import bump_shift
from breastrig_studies.virtual.warped.mastectomy import breast_region, filled
from breastrig_studies.virtual.warped.numbers import HANGING, Numbers, draw_numbers, with_hanging
from breastrig_studies.virtual.warped.proportions import changed
from breastrig_studies.virtual.warped.soundness import is_sound, is_sound_hanging
from breastrig_studies.virtual.warped.sources import Lying, Source
from breastrig_studies.virtual.warped.stances import carried, carrier

TRIES = 20


@dataclass(frozen=True, eq=False)
class WarpedBody:
    """A woman that was not there before, in body coordinates (m)."""

    source: Source
    numbers: Numbers
    lying: str  # the source's lying model
    tries: int  # how many were drawn until one was sound
    standing: VirtualBody
    supine: VirtualBody


def draw_body(
    source: Source, random: np.random.Generator, hanging: np.random.Generator | None = None, share: float = HANGING
) -> WarpedBody:
    """A body whose triangles are sound in both stances; numbers are drawn again until it is.

    `hanging` decides whether its breasts hang, as a `share` of all do, and how, and leaves all other numbers as they
    are; None: as the source's.
    """
    lying = source.lying[int(random.integers(len(source.lying)))]
    hangs = hanging is not None and bool(hanging.random() < share)
    for tries in range(1, TRIES + 1):
        numbers = draw_numbers(random)
        if hanging is not None and hangs:
            numbers = with_hanging(numbers, hanging)
        body = warped_body(source, lying, numbers, tries)
        if body is not None:
            return body
    raise RuntimeError(f"No sound warp of {source.name} in {TRIES} tries.")


def warped_body(source: Source, lying: Lying, numbers: Numbers, tries: int = 1) -> WarpedBody | None:
    """The body of these numbers; None when a triangle turned over."""
    before = source.standing, lying.vertices
    left_out: set[str] = set()
    if numbers.mastectomy:
        side = numbers.mastectomy
        places = source.landmarks(source.standing)
        nipple, fold = places[f"nipple_{side}"], places[f"inframammary_fold_{side}"]
        region = breast_region(source.standing, source.faces, nipple, fold, float(places["xiphoid"][0]))
        before = filled(before[0], source.faces, region), filled(before[1], source.faces, region)
        left_out = {f"nipple_{side}", f"inframammary_fold_{side}"}
    moved = changed(before[0], source.landmarks, numbers)
    moved = moved + bump_shift(moved, numbers.bumps)
    lain = carried(before[0], moved, before[1], lying.table, carrier(before[0], before[1], source.faces))
    sound = is_sound if numbers.nipples_over_folds is None else is_sound_hanging
    if not (sound(before[0], moved, source.faces) and sound(before[1], lain, source.faces)):
        return None

    def body(stance: str, vertices: Array, table: float | None) -> VirtualBody:
        places = {name: at for name, at in source.landmarks(vertices).items() if name not in left_out}
        return VirtualBody(stance, vertices, places, table)

    standing, supine = body("standing", moved, None), body("supine", lain, lying.table)
    return WarpedBody(source, numbers, lying.kind, tries, standing, supine)
