"""What a program can do with a body: pose it, draw others, know what is open, begin and lock, and arrays as scans."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.forearm import forearm_rig, posed_forearm, write_forearm

import breastrig
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.fitting.recipe import load_recipe
from breastrig.use.values.model import public

STANDING = asset_folder("example") / "standing" / "scan.ply"
PICKS = asset_folder("example") / "standing" / "landmarks.json"


@pytest.fixture(scope="module")
def fit() -> breastrig.Fit:
    return breastrig.fit(STANDING, PICKS, drawing=None)


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    return write_forearm(tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def arm_fit(arm: tuple[Path, Path, Path]) -> breastrig.Fit:
    return breastrig.fit(breastrig.read_scan(arm[1], "mm"), arm[2], model=arm[0])


@pytest.mark.slow
def test_the_parameters_of_a_refined_fit_pose_its_own_skin(fit: breastrig.Fit, tmp_path: Path) -> None:
    def off(found: breastrig.Fit) -> float:
        gaps = found.model.pose(found.parameters) - found.vertices
        return found.metres_per_unit * float(np.linalg.norm(gaps, axis=1).max())

    assert fit.result["refined"]
    assert off(fit) < 1e-6
    fit.save(tmp_path / "out")
    assert off(breastrig.Fit.load(tmp_path / "out")) < 1e-6
    bare = fit.model.pose(replace(fit.parameters, skin_layer=None))
    assert fit.metres_per_unit * np.linalg.norm(bare - fit.vertices, axis=1).max() > 1e-3
    plain = breastrig.fit(STANDING, PICKS, drawing=None, refine=False)
    assert off(plain) < 1e-6, "modes are in the layer, also without a free one"


@pytest.mark.slow
def test_a_layer_moves_with_the_bone_that_carries_it(arm_fit: breastrig.Fit) -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    bones = {
        name: replace(bone, rotation=turn @ bone.rotation, translation=turn @ bone.translation)
        for name, bone in arm_fit.parameters.bones.items()
    }
    turned = arm_fit.model.pose(replace(arm_fit.parameters, bones=bones))
    np.testing.assert_allclose(turned, arm_fit.vertices @ turn.T, atol=1e-3)  # mm
    with pytest.raises(breastrig.BadSettings, match="name other bones or shapes than torso"):
        breastrig.load_model().pose(arm_fit.parameters)


def test_bodies_that_are_drawn_keep_limits_and_joints_and_come_again_with_their_seed() -> None:
    for rig in (breastrig.load_model(), public(forearm_rig())):
        drawn = [rig.sample(np.random.default_rng(seed)) for seed in (1, 1, 2)]
        skins = [rig.pose(each) for each in drawn]
        np.testing.assert_array_equal(skins[0], skins[1])
        assert 0.001 < np.linalg.norm(skins[0] - skins[2], axis=1).mean() < 0.3
        for shape in rig.shapes:
            assert shape.min <= drawn[0].blendshapes[shape.name] <= shape.max
        bones = [drawn[0].bones[name] for name in rig.bone_names]
        for bone, limits in zip(bones, rig.bones, strict=True):
            assert np.all((limits.scale_min <= bone.scale) & (bone.scale <= limits.scale_max))
        for joint in rig.joints:
            ends = [
                bones[j].rotation @ (bones[j].scale * (rig.bones[j].rotation.T @ (joint.anchor - rig.bones[j].origin)))
                + bones[j].translation
                for j in (joint.parent, joint.child)
            ]
            assert np.linalg.norm(ends[0] - ends[1]) < 1e-9


def test_the_posterior_has_mean_covariance_and_names_and_stays_with_the_fit_and_its_files(
    fit: breastrig.Fit, tmp_path: Path
) -> None:
    known, rig = fit.posterior, fit.model
    unknowns = 9 * len(rig.bones) + len(rig.shapes)
    assert known.mean.shape == (unknowns,)
    assert known.covariance.shape == (unknowns, unknowns)
    assert np.linalg.eigvalsh(known.covariance).min() > 0.0
    assert list(known.blocks)[:3] == ["pelvis.rotation", "pelvis.translation", "pelvis.scale"]
    assert list(known.blocks)[-1] == rig.shape_names[-1]
    np.testing.assert_allclose(
        known.mean[known.blocks["lumbar.scale"]], fit.parameters.bones["lumbar"].scale, atol=1e-8
    )
    drawn = fit.metres_per_unit * fit.vertices - rig.pose(known.sample(np.random.default_rng(0)))
    assert 1e-4 < np.linalg.norm(drawn, axis=1).mean() < 0.02
    assert pickle.loads(pickle.dumps(fit)).posterior.mean.shape == known.mean.shape
    fit.save(tmp_path / "out")
    loaded = breastrig.Fit.load(tmp_path / "out").posterior
    np.testing.assert_array_equal(loaded.covariance, known.covariance)
    np.testing.assert_allclose(loaded.mean, known.mean, atol=1e-8)
    (tmp_path / "out" / "checks.bin").unlink()
    with pytest.raises(breastrig.BadInput, match="in no file of this fit"):
        _ = breastrig.Fit.load(tmp_path / "out").posterior


def test_the_radii_of_all_vertices_are_in_the_scans_unit_and_nan_without_calibration(
    fit: breastrig.Fit, arm_fit: breastrig.Fit
) -> None:
    in_metres = fit.metres_per_unit * fit.uncertainty
    assert in_metres.shape == (len(fit.vertices),)
    assert 5e-4 < in_metres.min() < in_metres.max() < 0.2
    assert np.isnan(arm_fit.uncertainty).all()


def test_a_fit_goes_on_from_another_and_locked_blocks_stay(
    arm: tuple[Path, Path, Path], arm_fit: breastrig.Fit
) -> None:
    scan, locked = breastrig.read_scan(arm[1], "mm"), ("scales", "long", "hand.rotation")
    again = breastrig.fit(scan, start=arm_fit, model=arm[0], refine=False)
    assert again.iterations < arm_fit.iterations
    assert again.stance == arm_fit.stance
    bent = replace(
        arm_fit.parameters,
        blendshapes=arm_fit.parameters.blendshapes | {"long": 0.5, "thick_upper": 0.9},
    )
    held = breastrig.fit(scan, start=bent, locked=locked, stance="standing", model=arm[0], refine=False)
    assert held.parameters.blendshapes["long"] == pytest.approx(0.5, abs=1e-6)
    assert held.parameters.blendshapes["thick_upper"] < 0.7  # 0.4 is true
    for name, bone in held.parameters.bones.items():
        np.testing.assert_allclose(bone.scale, arm_fit.parameters.bones[name].scale, atol=1e-6)
    np.testing.assert_allclose(
        held.parameters.bones["hand"].rotation, arm_fit.parameters.bones["hand"].rotation, atol=1e-6
    )
    with pytest.raises(breastrig.BadSettings, match='"elbow" is not a block of this model'):
        breastrig.fit(scan, locked=["elbow"], model=arm[0])
    with pytest.raises(breastrig.BadSettings, match="give stance as well"):
        breastrig.fit(scan, start=bent, model=arm[0])


def test_a_preset_is_given_by_what_differs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    default, last = load_recipe("default"), load_recipe("default").stages[-1]
    changed = load_recipe({"scales": {"sigma": 0.07}, "stages": {last.name: {"iterations": 3, "tighten": 2}}})
    assert (changed.scales.sigma, changed.scales.neighbour_sigma) == (0.07, default.scales.neighbour_sigma)
    assert [stage.name for stage in changed.stages] == [stage.name for stage in default.stages]
    assert (changed.stages[-1].iterations, changed.stages[-1].max_angle) == (3, last.max_angle)
    assert changed.name == "default, changed"
    mine = tmp_path / "mine.toml"
    mine.write_text('base = "paper"\nname = "mine"\n[scales]\nsigma = 0.3\n')
    found = load_recipe(mine)
    assert (found.name, found.scales.sigma, found.stages) == ("mine", 0.3, load_recipe("paper").stages)
    with pytest.raises(breastrig.BadSettings, match='"relax" is not a stage of the base'):
        load_recipe({"stages": {"relax": {}}})
    with pytest.raises(breastrig.BadSettings, match=r"scales\.sigma: "):
        load_recipe({"scales": {"sigma": -1.0}})
    assert main(["presets", "show", "paper"]) == 0
    shown = capsys.readouterr().out
    copied = tmp_path / "copied.toml"
    copied.write_text(shown)
    assert load_recipe(copied) == load_recipe("paper")
    assert main(["presets", "list"]) == 0
    assert capsys.readouterr().out == "default\npaper\n"
    assert main(["presets", "show", "nobody"]) == 2


@pytest.mark.slow
def test_arrays_and_meshes_of_a_program_are_scans(arm: tuple[Path, Path, Path], arm_fit: breastrig.Fit) -> None:
    mesh = trimesh.load_mesh(arm[1], process=False)
    scan = breastrig.Scan.from_arrays(mesh.vertices.tolist(), mesh.faces, unit="mm")
    assert (scan.unit, scan.metres_per_unit, scan.colours) == ("mm", 1e-3, None)
    np.testing.assert_allclose(scan.vertices, mesh.vertices)
    red = np.tile([1.0, 0.0, 0.0, 1.0], (len(mesh.vertices), 1))
    painted = breastrig.Scan.from_arrays(mesh.vertices, mesh.faces, red, "mm")
    assert painted.colours[0].tolist() == [255, 0, 0]
    assert painted.sha256 != scan.sha256
    mesh.units = "millimeters"
    assert breastrig.Scan.from_trimesh(mesh).unit == "mm"
    found = breastrig.fit(mesh, arm[2], model=arm[0])
    np.testing.assert_allclose(found.vertices, arm_fit.vertices, atol=0.01)


@pytest.mark.parametrize(
    ("vertices", "triangles", "colours", "words"),
    [
        ([[0, 0]], [[0, 0, 0]], None, "vertices has the shape"),
        (["here"], [[0, 0, 0]], None, "vertices"),
        ([[0, 0, 0]], [[0, 0, 1]], None, "triangles name vertices that do not exist"),
        ([[0, 0, 0]], [[0, 0, 0.5]], None, "whole numbers"),
        ([[0, 0, 0]], [[0, 0, 0]], [[0, 0, 0]] * 2, "There are 2 colours for 1 vertices"),
        ([[0, 0, 0]], [[0, 0, 0]], None, "only 1 triangle"),
    ],
)
def test_arrays_that_are_no_scan_are_refused_in_one_sentence(
    vertices: list, triangles: list, colours: list | None, words: str
) -> None:
    with pytest.raises(breastrig.BadScan, match=words):
        breastrig.Scan.from_arrays(vertices, triangles, colours, "m")


def test_a_drawing_is_carried_between_fits_of_another_rig_without_its_file(
    arm: tuple[Path, Path, Path], arm_fit: breastrig.Fit, fit: breastrig.Fit
) -> None:
    there = breastrig.transfer(arm_fit, arm_fit)
    [line] = there.lines
    [own] = arm_fit.drawing.lines
    ends = np.linalg.norm(line.points[[0, -1]] - own.points[[0, -1]], axis=1)
    assert ends.max() < 1.0  # mm
    with pytest.raises(breastrig.BadInput, match="made with several models"):
        breastrig.transfer(arm_fit, fit)
    with pytest.raises(breastrig.BadInput, match="made with several models"):
        breastrig.transfer(arm_fit, arm_fit, model=breastrig.load_model())


def test_a_notebook_shows_a_small_picture(arm_fit: breastrig.Fit) -> None:
    shown = arm_fit._repr_html_()
    assert shown.startswith('<figure><img alt="fitted model" src="data:image/png;base64,iVBOR')
    assert "Not calibrated for this rig" in shown
    assert len(shown) < 150_000
    assert posed_forearm(arm_fit.model)[0].shape == arm_fit.vertices.shape
