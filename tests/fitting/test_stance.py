"""Standing or lying, when the scan shows no table, or a plane that may be a table or a wall."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.core.assets import asset_folder
from breastrig.core.units import METRES_PER_UNIT
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting import hypotheses as stance_module
from breastrig.fitting.fit import FitTask
from breastrig.fitting.hypotheses import HANGS, MAY_HANG, STANDS, FoundStance, found_stance, scan_orientation
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts import stance_signs as signs_module
from breastrig.fitting.starts.orientation import best_start
from breastrig.fitting.starts.stance_signs import LikelyStance, stance_signs
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.similarity import umeyama
from breastrig.scan.clean import Surface, clean, compact
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.orient import Frame, propose_frame, table_plane
from breastrig.scan.read import read_scan

EXAMPLE = asset_folder("example")


def scan_without_table(place: Path) -> ScanTarget:
    surface = clean(read_scan(place / "scan.ply", None, "auto", texture=False))
    vertices, faces = surface.vertices - surface.vertices.mean(axis=0), surface.faces
    corners = vertices[faces]
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(crosses, axis=1)
    table = table_plane(corners.mean(axis=1), crosses / np.maximum(2.0 * areas[:, None], 1e-12), areas)
    if table is not None:
        above = (vertices @ table[0] > table[1] + 0.025)[faces].all(axis=1)
        vertices, faces = compact(vertices, faces[above])
    return ScanTarget(vertices, faces)


def found(target: ScanTarget) -> tuple[FoundStance, Frame]:
    rig, frame = read_rig(default_rig_path()), propose_frame(target.vertices, target.faces)
    none: dict[str, Array] = {}
    task = FitTask(
        rig,
        target,
        best_start(rig, target, none, lambda: frame.fronts),
        load_recipe("default"),
        {},
    ).with_picks(none)
    return found_stance(task, frame), frame


@pytest.mark.slow
@pytest.mark.parametrize("stance", ["standing", "supine"])
def test_the_body_tells_when_there_is_no_table(stance: str) -> None:
    answer, frame = found(scan_without_table(EXAMPLE / stance))
    assert "no table" in frame.stance_reason
    assert answer.stance == stance
    assert "no table" in answer.reason


@pytest.mark.slow
def test_where_the_signs_say_little_it_is_said_and_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    never_sure = stance_signs().model_copy(update={"unsure": 100.0})
    monkeypatch.setattr(signs_module, "stance_signs", lambda: never_sure)
    answer, _ = found(scan_without_table(EXAMPLE / "supine"))
    assert answer.stance == "supine"
    assert answer.reason.startswith("Without a table it is not clear:")
    assert answer.reason.endswith(". If the patient stands, say so.")


def test_a_table_needs_no_fit() -> None:
    surface = clean(read_scan(EXAMPLE / "supine" / "scan.ply", None, "auto", texture=False))
    target = ScanTarget(surface.vertices, surface.faces)
    frame = propose_frame(target.vertices, target.faces)
    assert frame.stance == "supine"
    rig = read_rig(default_rig_path())
    nothing = ScanTarget(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))  # a fit to it would fail
    task = FitTask(rig, nothing, rest_parameters(rig), load_recipe("default"), {})
    answer = found_stance(task, frame)
    assert (answer.stance, answer.reason, answer.iterates) == (frame.stance, frame.stance_reason, ())


def before_a_plane(stance: str, behind: float) -> Surface:
    """The packaged example, table cut away, upright in the scanner's axes; a plane ends `behind` (m) its hindmost."""
    place = EXAMPLE / stance
    target = prepared(clean(read_scan(place / "scan.ply", None, "auto", texture=False)), "auto").target
    rig = read_rig(default_rig_path())
    marks, unit = read_landmarks(place / "landmarks.json")
    names = tuple(name for name in rig.landmark_names if name in marks)
    true = {"mm": 1e-3, "m": 1.0}[str(unit)] * np.array([marks[name] for name in names])
    turn = umeyama(rig.landmark_points(names).positions(rig.template, rig.faces), true).rotation
    vertices = (target.vertices - true.mean(axis=0)) @ turn
    low = vertices.min(axis=0)
    along, up = (array.ravel() for array in np.meshgrid(np.linspace(-0.7, 0.7, 60), np.linspace(-0.6, 0.6, 60)))
    wall = np.column_stack([along, up, np.full(len(along), low[2] - behind)])
    corner = (60 * np.arange(59)[:, None] + np.arange(59)).ravel()
    squares = np.stack([corner, corner + 1, corner + 61, corner, corner + 61, corner + 60], axis=1).reshape(-1, 3)
    faces = np.concatenate([target.faces, len(vertices) + squares])
    return Surface(np.concatenate([vertices, wall]), faces, ())


@pytest.mark.slow
def test_a_wall_close_behind_a_standing_body_is_no_table() -> None:
    ready = prepared(before_a_plane("standing", 0.02), "auto")
    assert ready.frame.stance == "supine"  # as the plane alone has it
    answer = scan_orientation(read_rig(default_rig_path()), ready, load_recipe("default"))[0]
    assert answer.stance == "standing"
    assert "a wall. If it is a table, say that the patient lies." in answer.stance_reason


def test_a_table_that_a_scanner_sees_upright_is_a_table() -> None:
    ready = prepared(before_a_plane("supine", 0.0), "auto")
    answer = scan_orientation(read_rig(default_rig_path()), ready, load_recipe("default"))[0]
    assert answer.stance == "supine"
    assert "a table. If it is a wall, say that the patient stands." in answer.stance_reason


@pytest.mark.parametrize("turn", [np.eye(3), exp_so3(np.array([0.3, -1.1, 0.7]))])
def test_signs_are_measured_in_the_bodys_own_axes(turn: Array) -> None:
    rig = read_rig(default_rig_path())
    x, vertices = rest_parameters(rig), rig.template @ turn.T
    marks = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    bone = np.linalg.norm(marks["suprasternal_notch"] - marks["xiphoid"])
    forward = 0.5 * (marks["nipple_L"] + marks["nipple_R"])
    found = signs_module.breast_signs(rig, x, vertices, ScanTarget(vertices, rig.faces))
    assert found["nipples_in_front"] == pytest.approx((forward - marks["xiphoid"])[2] / bone, abs=0.01)
    assert all(found[name] > 0.05 for name in ("nipples_in_front", "nipples_over_folds", "facing_back"))


def test_an_arm_is_as_far_from_hanging_as_it_is_raised_on_its_own_side() -> None:
    rig = read_rig(default_rig_path())
    x = rest_parameters(rig).moved(exp_so3(np.array([0.3, -1.1, 0.7])), np.zeros(3))
    rest = signs_module.arm_angles(rig, x)
    arms = [name for name in rig.bone_names if name.startswith("upper_arm")]
    for number, name in enumerate(arms):
        bone = rig.bone_names.index(name)
        chest = x.rotations[rig.bones[rig.bones[bone].parent or 0].parent or 0]
        rotations = x.rotations.copy()
        sideways = np.cross(chest[:, 1], x.rotations[bone][:, 1])
        rotations[bone] = exp_so3(0.4 * sideways / np.linalg.norm(sideways)) @ rotations[bone]
        raised = signs_module.arm_angles(rig, replace(x, rotations=rotations))
        assert raised - rest == pytest.approx(0.4 * (np.arange(len(arms)) == number), abs=1e-6)


def test_a_small_front_of_a_standing_body_is_not_prone_though_its_breasts_stand_out() -> None:
    scan = read_scan(EXAMPLE / "standing" / "scan.ply", None, "auto", texture=False)
    places, unit = read_landmarks(EXAMPLE / "standing" / "landmarks.json")
    at = {name: METRES_PER_UNIT[unit or scan.unit] * np.asarray(place) for name, place in places.items()}
    surface, up = clean(scan), at["suprasternal_notch"] - at["xiphoid"]
    up, left = (each / np.linalg.norm(each) for each in (up, at["acromion_L"] - at["acromion_R"]))
    away = surface.vertices[surface.faces].mean(axis=1) - 0.5 * (at["nipple_L"] + at["nipple_R"])
    kept = (away @ up > -0.14) & (away @ up < 0.2) & (np.abs(away @ left) < 0.2)
    ready = prepared(Surface(*compact(surface.vertices, surface.faces[kept]), ()), "auto")
    orientation = scan_orientation(read_rig(default_rig_path()), ready, load_recipe("default"))[0]
    assert (orientation.stance, orientation.stance_reason) == ("standing", STANDS)
    assert orientation.start.rotation[:, 1] @ up > 0.9


@pytest.mark.parametrize(("sure", "reason"), [(True, HANGS), (False, MAY_HANG)])
def test_prone_is_found_by_signs_and_placed_as_such(monkeypatch: pytest.MonkeyPatch, sure: bool, reason: str) -> None:
    """Picks keep the fit from being known: their start is another."""
    rig = read_rig(default_rig_path())
    target = ScanTarget(rig.template, rig.faces)
    task = FitTask(rig, target, rest_parameters(rig), load_recipe("default"), {}).with_picks({"xiphoid": np.zeros(3)})
    monkeypatch.setattr(stance_module, "checked_iterates", lambda *_: ["the fit as standing"])
    monkeypatch.setattr(stance_module, "measured_signs", lambda *_: {})
    monkeypatch.setattr(stance_module, "likely_stance", lambda _: LikelyStance("prone", sure))
    start = SimpleNamespace(parameters=task.start, opening=None)
    monkeypatch.setattr(stance_module, "prone_start", lambda *_: start)
    answer = found_stance(task, propose_frame(target.vertices, target.faces))
    assert (answer.stance, answer.reason, answer.iterates, answer.start) == ("prone", reason, (), start)
