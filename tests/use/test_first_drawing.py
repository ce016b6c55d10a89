"""What is drawn when nobody says it: the rig's first drawing, and nothing on a rig that has none."""

from dataclasses import replace

import pytest
from helpers.forearm import forearm_rig

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.use.steps.prepare import fit_plan, named_drawing
from breastrig.use.steps.settings import FIRST, FitSettings


@pytest.mark.parametrize(
    ("asked", "of_the_torso", "of_none"),
    [
        (FIRST, "lumpectomy", None),
        (f"{FIRST}+tumour:L,10,45,12", "lumpectomy+tumour:L,10,45,12", "tumour:L,10,45,12"),
        ("anatomy", "anatomy", "anatomy"),
        (None, None, None),
    ],
)
def test_first_is_the_rigs_own(asked: str | None, of_the_torso: str | None, of_none: str | None) -> None:
    torso = read_rig(default_rig_path())
    assert named_drawing(torso, asked) == of_the_torso
    assert named_drawing(replace(torso, drawings=()), asked) == of_none


def test_a_fit_of_another_rig_draws_its_first_or_nothing() -> None:
    torso = read_rig(default_rig_path())
    plans = [fit_plan(FitSettings(), rig, {}) for rig in (torso, forearm_rig(), replace(forearm_rig(), drawings=()))]
    assert [plan.settings.drawing for plan in plans] == ["lumpectomy", "incision", None]
    assert plans[2].drawing is None
