"""A label map says where left, head and front are: its fit never turns the body round, however little it shows."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import nibabel
import numpy as np
from helpers.label_maps import front_labels, in_lps

from breastrig.fitting.prepare_scan import prepared_scan
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import best_start, contradicted, sides_exchanged
from breastrig.fitting.starts.rigid_search import OBLIQUE, turned_from
from breastrig.fitting.verdicts.reasons import of_lesions
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.similarity import body_axes
from breastrig.rig.skinning import pose
from breastrig.scan.orient import LABEL_MAP_FRAME
from breastrig.scan.piece import BallInside
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan
from breastrig.scan.stored_scan import STORED, write_stored
from breastrig.use.landmarks import propose_on_scan

RIG = read_rig(default_rig_path())
LESION = np.array([0.08, 0.24, 0.1])  # m, inside the left breast of the template


def places() -> dict[str, np.ndarray]:
    """mm, LPS, of the template's landmarks."""
    at = RIG.landmark_points().positions(RIG.template, RIG.faces)
    return dict(zip(RIG.landmark_names, in_lps(at), strict=True))


@cache
def scan_of_front() -> Scan:
    """That of the front as it is."""
    return read_scan(map_of_front(np.eye(3)))


def map_of_front(turn: np.ndarray, codes: str = "LPS", around_mm: tuple[float, float] = (60.0, 60.0)) -> bytes:
    """NIfTI of the template's front around its breasts, turned in the scanner, stored in any order of voxels."""
    at = places()
    labels, low, size = front_labels(RIG, LESION, 8.0, 3.0)
    middle = 0.5 * (at["nipple_L"] + at["nipple_R"])[2]
    kept = slice(*(int((middle + each - low[2]) / size) for each in (-around_mm[0], around_mm[1])))
    labels, low = labels[:, :, kept], low + np.array([0.0, 0.0, kept.start * size])
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = size * turn, turn @ low
    image = nibabel.Nifti1Image(labels, np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine)
    image = image.as_reoriented(nibabel.orientations.axcodes2ornt(tuple(codes)))
    image.set_sform(image.affine, 1)
    image.set_qform(image.affine, 1)
    image.header.set_xyzt_units("mm")
    return bytes(image.to_bytes())


def test_a_cut_and_oblique_map_is_never_turned_round() -> None:
    turn = exp_so3(np.array([-0.5, 0.0, 0.0]))
    scan = read_scan(map_of_front(turn, "IRA"))
    proposed = propose_on_scan(RIG, scan)
    for name in ("nipple_L", "nipple_R"):
        assert np.linalg.norm(1e3 * proposed[name].point - turn @ places()[name]) < 40.0


def in_m(turn: np.ndarray) -> dict[str, np.ndarray]:
    return {name: 1e-3 * turn @ place for name, place in places().items()}


def test_landmarks_do_not_turn_the_body_against_its_axes() -> None:
    ready = prepared_scan(scan_of_front(), "auto")
    round_about = np.diag([-1.0, 1.0, -1.0])  # head and feet, left and right exchanged
    picks = in_m(round_about)
    for axes, is_turned in ((None, True), (LABEL_MAP_FRAME.known, False)):
        start = best_start(RIG, ready.target, picks, lambda: LABEL_MAP_FRAME.fronts, None, axes)
        assert turned_from(body_axes(RIG, pose(RIG, start)), LABEL_MAP_FRAME.rotation, OBLIQUE) == is_turned


def test_two_breasts_and_a_breastbone_tell_exchanged_sides_where_axes_are_known() -> None:
    scan, outliers = prepared_scan(scan_of_front(), "auto"), load_recipe("default").outliers
    names = {"nipple_L": "nipple_R", "nipple_R": "nipple_L", "xiphoid": "xiphoid"}
    true = {name: in_m(np.eye(3))[name] for name in names}
    exchanged = {names[name]: place for name, place in true.items()}
    assert not sides_exchanged(RIG, true, scan.target, outliers, scan.frame.known)
    assert sides_exchanged(RIG, exchanged, scan.target, outliers, scan.frame.known)


def test_a_body_that_lies_the_other_way_round_contradicts_its_file() -> None:
    for turn, is_contradicted in ((np.eye(3), False), (np.diag([-1.0, 1.0, -1.0]), True)):
        ready = prepared_scan(read_scan(map_of_front(turn, around_mm=(90.0, 150.0))), "auto")
        assert contradicted(RIG, ready.target, ready.frame, "prone") == is_contradicted
    assert not contradicted(RIG, ready.target, replace(ready.frame, confidence=0.5), "prone")


def test_what_is_stored_of_a_label_map_still_knows_its_axes_and_lesions(tmp_path: Path) -> None:
    scan = scan_of_front()
    write_stored(scan, tmp_path / "kept")
    stored = read_scan(tmp_path / "kept", STORED)
    assert prepared_scan(stored, "auto").frame is LABEL_MAP_FRAME
    assert [(each.name, *each.center, each.radius) for each in stored.lesions] == [
        (each.name, *each.center, each.radius) for each in scan.lesions
    ]


def test_a_mesh_in_the_same_place_has_no_known_axes() -> None:
    scan = scan_of_front()
    mesh = replace(scan, from_label_map=False, lesions=())
    assert prepared_scan(mesh, "auto").frame.known is None


def test_a_lesion_outside_or_far_away_is_a_reason_and_leaves_no_radius() -> None:
    inside, near = (
        BallInside("Lesion 1", LESION, 0.008),
        BallInside("Lesion 2", LESION + np.array([0.0, 0.0, 0.2]), 0.008),
    )
    far = BallInside("Lesion 3", np.array([0.0, 0.0, 0.0]), 0.008)
    assert of_lesions(RIG, RIG.template, [inside]) == ((), False)
    reasons, outside = of_lesions(RIG, RIG.template, [inside, near, far])
    assert outside
    assert ["Lesion 2" in str(reasons[0]), "outside the fitted skin" in str(reasons[0])] == [True, True]
    assert ["Lesion 3" in str(reasons[1]), "far from the breasts" in str(reasons[1])] == [True, True]
    assert not of_lesions(RIG, RIG.template, [far])[1]
