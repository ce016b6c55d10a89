"""The signs of a stance: each speaks for its side, no single fit's energy outweighs the others, size says nothing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.starts.supine_or_standing import breast_signs, likely_stance, stance_signs
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.scan.clean import compact


def as_scanned(rig: Rig, vertices: Array) -> dict[str, float]:
    """The signs of vertices (V, 3) m that lie on their scan."""
    return breast_signs(rig, vertices, ScanTarget(vertices, rig.faces))


def in_between() -> dict[str, float]:
    return {name: sign.between for name, sign in stance_signs().signs.items()}


@pytest.mark.parametrize(
    ("sign", "lying"), [("arms", 1.2), ("nipples_apart", 1.5), ("nipples_in_front", 0.0), ("energy_less", 8.0)]
)
def test_each_sign_speaks_for_lying_on_its_own_side(sign: str, lying: float) -> None:
    middle = in_between()[sign]
    odds = [stance_signs().log_odds(in_between() | {sign: value}) for value in (2.0 * middle - lying, middle, lying)]
    assert odds[0] < 0.0 < odds[2]
    assert odds[1] == 0.0


def test_what_says_nothing_is_unsure_and_what_all_signs_say_is_sure() -> None:
    assert not likely_stance(in_between()).sure
    assert not likely_stance({}).sure
    lying = {"nipples_in_front": 0.05, "nipples_apart": 1.3, "arms": 1.2}
    standing = {"nipples_in_front": 0.25, "nipples_apart": 1.0, "arms": 0.55}
    assert (likely_stance(lying).supine, likely_stance(lying).sure) == (True, True)
    assert (likely_stance(standing).supine, likely_stance(standing).sure) == (False, True)


def test_energies_that_are_far_apart_count_no_more_than_those_at_the_limit() -> None:
    signs = stance_signs()
    most = signs.signs["energy_less"].most
    assert most is not None
    assert signs.log_odds({"energy_less": 60.0}) == signs.log_odds({"energy_less": most})
    assert signs.log_odds({"energy_less": -60.0}) == signs.log_odds({"energy_less": -most})


def test_size_place_and_direction_of_a_body_say_nothing() -> None:
    rig = read_rig(default_rig_path())
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    elsewhere = as_scanned(rig, 1.3 * rig.template @ turn.T + [0.2, -3.0, 1.0])
    assert elsewhere == pytest.approx(as_scanned(rig, rig.template), abs=1e-9)


def test_of_half_a_body_it_is_not_seen_how_far_the_nipples_are_apart() -> None:
    rig = read_rig(default_rig_path())
    left = rig.faces[(rig.template[:, 0] > 0.0)[rig.faces].all(axis=1)]
    whole = as_scanned(rig, rig.template)
    assert breast_signs(rig, rig.template, ScanTarget(*compact(rig.template, left))) == {
        "nipples_in_front": whole["nipples_in_front"]
    }


def test_nipples_that_move_back_and_outwards_are_seen() -> None:
    rig = read_rig(default_rig_path())
    moved = rig.template.copy()
    sides = np.sign(moved[:, 0])
    for name in ("areola_L", "areola_R"):
        chosen = rig.regions[name]
        moved[chosen] += np.column_stack([0.02 * sides[chosen], np.zeros(len(chosen)), np.full(len(chosen), -0.02)])
    before, after = as_scanned(rig, rig.template), as_scanned(rig, moved)
    assert after["nipples_apart"] > before["nipples_apart"]
    assert after["nipples_in_front"] < before["nipples_in_front"]


def test_of_a_rig_without_the_landmarks_the_breasts_say_nothing() -> None:
    rig = read_rig(default_rig_path())
    none = replace(rig, landmarks=tuple(each for each in rig.landmarks if each.name != "xiphoid"))
    assert as_scanned(none, rig.template) == {}
