"""A woman of the cohort that is solved under gravity."""

from pathlib import Path

import numpy as np
import pytest

from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.volume.breast_skin import breast_skins
from breastrig.volume.tetrahedra import chest_wall
from breastrig_studies.gravity import solved as study
from breastrig_studies.gravity.estimate import read_women
from breastrig_studies.gravity.soft_breast import published


def test_the_wall_under_the_template_is_the_rigs_and_larger_breasts_leave_it_where_it_is(rig: Rig) -> None:
    wall = chest_wall(rig, rest_parameters(rig), rig.template)
    assert study.carried_wall(rig, rig.template, 1.0) == pytest.approx(wall, abs=1e-9)
    larger = rig.template.copy()
    for side in breast_skins(rig):
        larger[side.skin[side.breast]] += 0.4 * side.heights(rig.template)[side.breast]
    assert study.carried_wall(rig, larger, 1.0) == pytest.approx(wall, abs=1e-9)


def test_a_stiff_woman_is_solved_in_four_positions_that_the_estimate_reads(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = published()
    stiff = {name: dict(part) for name, part in table.items()}
    for name in ("fat", "skin"):
        stiff[name]["median"] *= 8.0
    monkeypatch.setattr(study, "published", lambda: stiff)
    found = study.solved(rig, rig.template, np.random.default_rng(3))
    np.savez(tmp_path / "0000.npz", **found)
    (woman,) = read_women(rig, tmp_path)
    nipple = np.isin(breast_skins(rig)[0].skin, rig.regions["areola_L"])
    unloaded = found["unloaded_skin"][nipple].mean(axis=0)
    supine, prone = (
        (woman.heights[name] - woman.heights["standing"]).reshape(-1, 3)[nipple].mean(axis=0)
        for name in ("supine", "prone")
    )
    assert unloaded[1] > 0.001  # up
    assert supine[2] < unloaded[2] < prone[2]
    assert supine[0] > prone[0]  # outwards
