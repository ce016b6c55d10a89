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
from breastrig.rig.parameters import rest_parameters
from breastrig.scan.clean import compact
from breastrig_studies.virtual.bodies import closed


def as_scanned(rig: Rig, vertices: Array) -> dict[str, float]:
    """The signs of vertices (V, 3) m that lie on their scan."""
    return breast_signs(rig, rest_parameters(rig), vertices, ScanTarget(vertices, rig.faces))


def in_between() -> dict[str, float]:
    return {name: sign.between for name, sign in stance_signs().signs.items()}


@pytest.mark.parametrize(
    ("sign", "towards"),
    [
        ("nipples_over_folds", 1),
        ("aside", 1),
        ("nipples_in_front", -1),
        ("flattened", -1),
        ("facing_back", -1),
        ("upright", -1),
    ],
)
def test_each_sign_speaks_for_lying_on_its_own_side_and_no_more_than_so_much(sign: str, towards: int) -> None:
    known = stance_signs().signs[sign]
    steps = np.array([-9.0, -1.0, 0.0, 1.0, 9.0]) * towards * known.most
    odds = [stance_signs().log_odds(in_between() | {sign: known.between + step}) for step in steps]
    assert odds[0] == pytest.approx(odds[1])
    assert odds[3] == pytest.approx(odds[4])
    assert odds[1] < odds[2] < odds[3]
    assert odds[2] == pytest.approx(stance_signs().constant)


def test_arms_do_not_make_a_standing_body_lie() -> None:
    standing = {"nipples_in_front": 0.16, "nipples_over_folds": 0.17, "flattened": 0.3}
    lying = {"nipples_in_front": 0.03, "nipples_over_folds": 0.28, "flattened": -0.9}
    for arms in np.radians([5.0, 45.0, 90.0]):
        assert not likely_stance(standing | {"arms": arms}).supine
        assert likely_stance(lying | {"arms": arms}).supine


def test_a_breast_that_gravity_can_hardly_move_says_as_much_less() -> None:
    standing = {"nipples_in_front": 0.16, "nipples_over_folds": 0.17, "flattened": 0.3}
    usual = stance_signs().log_odds(standing)
    assert stance_signs().log_odds(standing | {"length": 0.4 * stance_signs().length}) == pytest.approx(0.4 * usual)
    assert likely_stance(standing).sure
    assert not likely_stance(standing | {"length": 0.4 * stance_signs().length}).sure


def test_what_says_nothing_is_unsure_and_what_all_signs_say_is_sure() -> None:
    assert not likely_stance(in_between()).sure
    assert not likely_stance({}).sure
    most = {name: s.between + np.sign(s.weight) * s.most for name, s in stance_signs().signs.items()}
    least = {name: s.between - np.sign(s.weight) * s.most for name, s in stance_signs().signs.items()}
    assert (likely_stance(most).supine, likely_stance(most).sure) == (True, True)
    assert (likely_stance(least).supine, likely_stance(least).sure) == (False, True)


def test_size_place_and_direction_of_a_body_say_nothing() -> None:
    rig = read_rig(default_rig_path())
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    elsewhere = as_scanned(rig, 1.3 * rig.template @ turn.T + [0.2, -3.0, 1.0])
    assert elsewhere == pytest.approx(as_scanned(rig, rig.template), abs=1e-9)


def test_nipples_that_move_back_are_seen() -> None:
    rig = read_rig(default_rig_path())
    moved = rig.template.copy()
    for name in ("areola_L", "areola_R"):
        moved[rig.regions[name], 2] -= 0.02
    before, after = as_scanned(rig, rig.template), as_scanned(rig, moved)
    assert after["nipples_in_front"] < before["nipples_in_front"]


@pytest.mark.parametrize("side", ["L", "R"])
def test_a_breast_that_is_gone_says_nothing(side: str) -> None:
    rig = read_rig(default_rig_path())
    moved = rig.template.copy()
    moved[rig.regions[f"areola_{side}"], 2] -= 0.06
    weights = np.where(np.array(rig.shape_names) == f"projection_{side}", -2.0, 0.0)
    seen = breast_signs(rig, replace(rest_parameters(rig), weights=weights), moved, ScanTarget(moved, rig.faces))
    assert seen == pytest.approx(as_scanned(rig, rig.template), abs=0.03)


def test_skin_that_faces_backwards_is_seen_where_the_scan_shows_it() -> None:
    rig = read_rig(default_rig_path())
    front = rig.faces[(rig.template[:, 2] > np.median(rig.template[:, 2]))[rig.faces].all(axis=1)]
    assert as_scanned(rig, rig.template)["facing_back"] > 0.25
    shown = breast_signs(rig, rest_parameters(rig), rig.template, ScanTarget(*compact(rig.template, front)))
    assert shown["facing_back"] < 0.05


def test_the_back_of_a_surface_that_a_program_has_closed_says_nothing() -> None:
    rig = read_rig(default_rig_path())
    scan = ScanTarget(*closed(rig.template, rig.faces))
    assert "facing_back" not in breast_signs(rig, rest_parameters(rig), rig.template, scan)


def test_of_a_rig_without_the_landmarks_the_breasts_say_nothing() -> None:
    rig = read_rig(default_rig_path())
    none = replace(rig, landmarks=tuple(each for each in rig.landmarks if each.name != "xiphoid"))
    assert as_scanned(none, rig.template) == {}
