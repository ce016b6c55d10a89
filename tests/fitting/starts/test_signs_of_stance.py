"""The signs of a stance: each speaks for its side, no single fit's energy outweighs the others, size says nothing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.starts.stance_signs import LikelyStance, breast_signs, likely_stance, stance_signs
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.scan.clean import compact
from breastrig_studies.virtual.bodies import closed

HIGH = {"height": 0.5, "cleft": 0.03}  # m, as whole scans are: no MRI
LENGTH = stance_signs().supine.length or 0.0


def as_scanned(rig: Rig, vertices: Array) -> dict[str, float]:
    """The signs of vertices (V, 3) m that lie on their scan."""
    return breast_signs(rig, rest_parameters(rig), vertices, ScanTarget(vertices, rig.faces))


def in_between() -> dict[str, float]:
    return {name: sign.between for name, sign in stance_signs().supine.signs.items()}


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
    known = stance_signs().supine.signs[sign]
    steps = np.array([-9.0, -1.0, 0.0, 1.0, 9.0]) * towards * known.most
    odds = [stance_signs().supine.log_odds(in_between() | {sign: known.between + step}) for step in steps]
    assert odds[0] == pytest.approx(odds[1])
    assert odds[3] == pytest.approx(odds[4])
    assert odds[1] < odds[2] < odds[3]
    assert odds[2] == pytest.approx(stance_signs().supine.constant)


def test_arms_do_not_make_a_standing_body_lie() -> None:
    standing = {"nipples_in_front": 0.16, "nipples_over_folds": 0.17, "flattened": 0.3}
    lying = {"nipples_in_front": 0.03, "nipples_over_folds": 0.28, "flattened": -0.9}
    for arms in np.radians([5.0, 45.0, 90.0]):
        assert likely_stance(standing | {"arms": arms}).stance == "standing"
        assert likely_stance(lying | {"arms": arms}).stance == "supine"


def test_a_breast_that_gravity_can_hardly_move_says_as_much_less() -> None:
    standing = {"nipples_in_front": 0.16, "nipples_over_folds": 0.17, "flattened": 0.3}
    usual = stance_signs().supine.log_odds(standing)
    assert stance_signs().supine.log_odds(standing | {"length": 0.4 * LENGTH}) == pytest.approx(0.4 * usual)
    assert likely_stance(standing | HIGH).sure
    assert not likely_stance(standing | HIGH | {"length": 0.4 * LENGTH}).sure


def test_breasts_that_hang_before_a_chest_as_high_as_an_mri_shows_are_prone() -> None:
    hanging = {"nipples_in_front": 0.45, "cleft": 0.09, "nipples_over_folds": 0.2, "height": 0.2}
    assert likely_stance(hanging) == LikelyStance("prone", True)
    assert likely_stance(hanging | {"height": 0.5}).stance == "standing"
    assert likely_stance(hanging | {"nipples_in_front": 0.15, "cleft": 0.03}).stance == "standing"


def test_what_says_nothing_is_unsure_and_what_all_signs_say_is_sure() -> None:
    assert not likely_stance(in_between() | HIGH).sure
    assert not likely_stance(HIGH).sure
    most = {name: s.between + np.sign(s.weight) * s.most for name, s in stance_signs().supine.signs.items()}
    least = {name: s.between - np.sign(s.weight) * s.most for name, s in stance_signs().supine.signs.items()}
    assert likely_stance(most | HIGH) == LikelyStance("supine", True)
    assert likely_stance(least | HIGH) == LikelyStance("standing", True)


def test_size_place_and_direction_of_a_body_say_nothing() -> None:
    """But the cleft, in m: MRIs are of one size."""
    rig = read_rig(default_rig_path())
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    elsewhere = as_scanned(rig, 1.3 * rig.template @ turn.T + [0.2, -3.0, 1.0])
    here = as_scanned(rig, rig.template)
    assert elsewhere.keys() == here.keys()
    assert elsewhere | {"cleft": here["cleft"]} == pytest.approx(here, abs=1e-9)


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
