"""The tracked model keeps its promises."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
from torso_rules import LANDMARKS, torso_findings

from breastrig.core.assets import packaged_models
from breastrig.gltf.read_rig import read_rig
from breastrig.rig.model import Rig
from breastrig.rig.skinning import shaped
from breastrig.rig.validation.rules import check_rig
from breastrig.use.values.model import load_model

BUILD_AGAIN = (
    "run: python model_assets/build.py, then again with --recipe model_assets/male.toml, "
    "then commit all of model_assets/built"
)
FLIP = np.array([-1.0, 1.0, 1.0])


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _smallest_angles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    corners = vertices[faces]
    angles = []
    for i in range(3):
        u, w = corners[:, (i + 1) % 3] - corners[:, i], corners[:, (i + 2) % 3] - corners[:, i]
        cosine = (u * w).sum(1) / (np.linalg.norm(u, axis=1) * np.linalg.norm(w, axis=1))
        angles.append(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
    return np.min(angles, axis=0)


RECIPES = {".": {"recipe.toml"}, "male": {"recipe.toml", "male.toml"}}  # of the folders of built/


@pytest.mark.parametrize("folder", RECIPES)
def test_the_tracked_files_are_those_of_the_manifest(model_assets: Path, folder: str) -> None:
    built = model_assets / "built" / folder
    manifest = json.loads((built / "MANIFEST.json").read_text(encoding="utf-8"))
    places = [built, built / "drawings"]
    made = [p.relative_to(built) for place in places for p in place.iterdir() if p.is_file()]
    files = {p.as_posix() for p in made} - {"MANIFEST.json"}
    assert files == set(manifest["outputs"]), BUILD_AGAIN
    assert {name: _sha256(built / name) for name in files} == manifest["outputs"], BUILD_AGAIN


@pytest.mark.parametrize("folder", RECIPES)
def test_the_model_was_built_from_these_steps_and_this_recipe(model_assets: Path, folder: str) -> None:
    inputs = json.loads((model_assets / "built" / folder / "MANIFEST.json").read_text(encoding="utf-8"))["inputs"]
    own = {name: digest for name, digest in inputs.items() if not name.endswith(".whl")}
    steps = {f"steps/{p.name}" for p in (model_assets / "steps").glob("*.py")}
    assert set(own) == steps | RECIPES[folder], BUILD_AGAIN
    assert {name: _sha256(model_assets / name) for name in own} == own, BUILD_AGAIN


def test_every_rule_of_the_contract_is_kept(torso: Rig) -> None:
    assert [finding for finding in torso_findings(torso) if not finding.ok] == []


def test_the_chest_of_a_man_keeps_the_rules_of_any_rig_and_has_his_drawings() -> None:
    male = load_model("male")
    assert [finding for finding in check_rig(male) if not finding.ok] == []
    assert set(LANDMARKS) <= set(male.landmark_names)
    assert male.drawing_names == ("anatomy", "mastectomy", "gynaecomastia")
    webster = next(shape for shape in male.drawings[2].shapes if shape.name == "webster_L")
    line = webster.points.positions(male.template, male.faces)
    nipple = male.template[male.faces[male.landmarks[male.landmark_names.index("nipple_L")].face]].mean(axis=0)
    apart = np.linalg.norm(line - nipple, axis=1)
    assert (line[:, 1] < nipple[1] + 0.003).all()  # below the nipple, along an areola of 30 mm
    assert 0.011 < apart.min() < apart.max() < 0.018
    at = dict(zip(male.landmark_names, male.landmark_points().positions(male.template, male.faces), strict=True))
    assert (
        abs(at["inframammary_fold_L"][0] - at["nipple_L"][0]) < 0.007
    )  # straight below, where a flat chest has no fold


def test_left_and_right_agree_to_a_hundredth_of_a_millimetre(torso: Rig) -> None:
    mirror = torso.mirror_vertices
    assert np.array_equal(mirror[mirror], np.arange(len(mirror)))
    assert np.abs(FLIP * torso.template[mirror] - torso.template).max() < 1e-5
    middle = mirror == np.arange(len(mirror))
    assert np.abs(torso.template[middle, 0]).max() == 0.0
    for index, shape in enumerate(torso.shapes):
        partner = torso.shape_names.index(shape.mirror)
        assert np.abs(FLIP * torso.blendshapes[partner][mirror] - torso.blendshapes[index]).max() < 1e-5


def test_edges_are_short_on_the_breasts_and_longer_elsewhere(torso: Rig) -> None:
    faces = torso.faces
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    lengths = np.linalg.norm(torso.template[edges[:, 0]] - torso.template[edges[:, 1]], axis=1)
    breasts = np.concatenate([torso.regions["breast_L"], torso.regions["breast_R"]])
    on_breasts = np.isin(edges, breasts).all(axis=1)
    assert np.median(lengths[on_breasts]) <= 0.009
    assert np.median(lengths[~on_breasts]) > 0.011
    assert np.median(lengths[np.isin(edges, torso.regions["back"]).all(axis=1)]) > 0.018


def test_no_triangle_is_a_sliver_in_the_template_or_any_shape(torso: Rig) -> None:
    assert _smallest_angles(torso.template, torso.faces).min() > 20.0
    for index in range(len(torso.shapes)):
        weights = np.zeros(len(torso.shapes))
        weights[index] = 1.0
        assert _smallest_angles(shaped(torso, weights), torso.faces).min() > 8.0, torso.shape_names[index]


def test_supine_spread_keeps_the_volume(torso: Rig) -> None:
    def volume(vertices: np.ndarray) -> float:
        return float(np.linalg.det(vertices[torso.faces]).sum() / 6.0)

    weights = np.zeros(len(torso.shapes))
    flat = torso.shape_names.index("supine_spread_L")
    small = torso.shape_names.index("volume_small_L")
    weights[small] = 1.0
    breast = volume(torso.template) - volume(shaped(torso, weights))
    weights[small], weights[flat] = 0.0, 1.0
    change = volume(shaped(torso, weights)) - volume(torso.template)
    assert abs(change) < 0.12 * breast


def test_no_shape_is_nearly_a_mixture_of_the_others(torso: Rig) -> None:
    flat = torso.blendshapes.reshape(len(torso.shapes), -1)
    unit = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    assert np.linalg.eigvalsh(unit @ unit.T).min() > 0.01


def test_drawings_lie_in_even_steps_on_the_skin(torso: Rig) -> None:
    for drawing in torso.drawings:
        for shape in drawing.shapes:
            points = shape.points.positions(torso.template, torso.faces)
            steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
            assert steps.min() > 0.003, f"{drawing.name} {shape.name}"
            assert steps.max() < 0.009, f"{drawing.name} {shape.name}"


@pytest.mark.parametrize("side", ["L", "R"])
def test_stewarts_ellipse_runs_from_beside_the_sternum_up_to_the_axilla_around_the_areola(
    torso: Rig, side: str
) -> None:
    shapes = {shape.name: shape for drawing in torso.drawings for shape in drawing.shapes}
    ellipse = shapes[f"stewart_{side}"]
    line = ellipse.points.positions(torso.template, torso.faces)
    nipple = torso.landmark_points((f"nipple_{side}",)).positions(torso.template, torso.faces)[0]
    medial, lateral = line[list(ellipse.corners)]
    assert ellipse.closed
    assert 0.02 < abs(medial[0]) < 0.04  # the sternum's border
    assert medial[1] < nipple[1] < lateral[1] - 0.02
    assert lateral[2] < nipple[2] - 0.08  # around the side
    areola = torso.template[torso.regions[f"areola_{side}"]]
    gaps = np.linalg.norm(line[:, None] - areola, axis=2).min(axis=0)
    assert gaps.min() > 0.008
    half = len(line) // 2
    assert np.linalg.norm(line[half // 2] - line[-half // 2]) > 0.05  # as wide as it must be to hold the areola


def test_landmarks_stand_where_anatomy_has_them(torso: Rig) -> None:
    points = torso.landmark_points().positions(torso.template, torso.faces)
    at = dict(zip(torso.landmark_names, points, strict=True))
    heights = [at[name][1] for name in ("suprasternal_notch", "mid_sternum", "xiphoid", "umbilicus")]
    assert heights == sorted(heights, reverse=True)
    assert at["inframammary_fold_L"][1] < at["nipple_L"][1] < at["midclavicle_L"][1]
    assert at["acromion_L"][0] > at["midclavicle_L"][0] > 0 > at["midclavicle_R"][0]
    assert abs(at["xiphoid"][1] - 0.5 * (at["inframammary_fold_L"][1] + at["inframammary_fold_R"][1])) < 0.002


@pytest.mark.parametrize("glb", packaged_models().values(), ids=packaged_models())
def test_what_is_known_of_a_model_is_bound_to_it_as_it_is(glb: Path) -> None:
    rig, folder = read_rig(glb), glb.with_suffix(".known")
    assert json.loads((folder / "rig.json").read_text())["rig_sha256"] == rig.sha256, (
        f"a build has changed the model: see whether {folder.name} still holds, then run: breastrig model bind"
    )
    assert set(rig.known) == {file.name for file in folder.iterdir()} - {"rig.json"}
