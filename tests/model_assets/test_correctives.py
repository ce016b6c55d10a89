"""Shapes that a shoulder's turn drives: what they are learnt from stands still at rest, and they say it again."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from breastrig.rig.model import Corrective, Rig
from breastrig.rig.skinning import PosedWithCorrectives


@pytest.fixture(scope="module")
def made(model_assets: Path) -> Any:
    import correctives

    return correctives


def test_flesh_stands_still_at_rest_and_its_cores_follow_their_bones(
    made: Any, torso: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(made, "ROUNDS", 1)
    flesh = made.Flesh(torso)
    np.testing.assert_allclose(flesh.skin_in(made.raised(torso, made.REST)), torso.template, atol=1e-9)
    mirrored = flesh.owner[: flesh.skin][torso.mirror_vertices]
    for joint in made.shoulders(torso):
        bone = torso.joints[joint].child
        other = torso.bone_names.index(torso.bones[bone].mirror)
        assert 10 < (flesh.owner[: flesh.skin] == bone).sum() == (mirrored == other).sum()


def test_a_corrected_skin_gives_its_correctives_again(made: Any, torso: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(made, "RIDGE", 1e-12)
    beside = np.abs(torso.template[:, :1]) > 0.05
    bulge = 0.01 * beside * np.cos(9.0 * torso.template) * [1.0, -1.0, 0.5]
    first, second = made.shoulders(torso)
    side = np.sign(torso.template[:, :1] * torso.joints[first].anchor[0])
    known = (
        Corrective("one", first, (0, 0, 2), bulge * (side > 0.0)),
        Corrective("two", second, (0, 0, 2), bulge * (side < 0.0)),
    )
    rig = replace(torso, skinning="corrective", correctives=known)
    skins = [PosedWithCorrectives(rig, made.raised(torso, degrees)).vertices for degrees in made.LEARNT]
    found = made.correctives(torso, skins)
    assert [each.powers for each in found] == 2 * [(0, 0, 1), (0, 0, 2), (0, 0, 3)]
    for each in found:
        expected = sum(one.moves for one in known if (one.joint, one.powers) == (each.joint, each.powers))
        np.testing.assert_allclose(each.moves, expected + np.zeros_like(bulge), atol=1e-6)
