"""The preset `paper` is the paper's energy: equations 4 to 9 written out again, term by term, in centimetres."""

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.core.errors import BadSettings
from breastrig.correspondence.match import Correspondences
from breastrig.energies.point_to_point import PointToPoint
from breastrig.fitting import recipe
from breastrig.fitting.fit import ScanProblem, projected
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.task import FitTask
from breastrig.geometry.rotations import log_so3
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from breastrig.rig.state import BodyState

CM = 100.0  # per metre
DATA, SCALES, SHAPES, JOINTS, LANDMARKS = 10e-3, 10e-2, 10e-3, 10e-2, 10e-4  # the paper's λ, as printed


@pytest.fixture(scope="module")
def fit(torso: Rig) -> ScanProblem:
    target, landmarks, _ = patient(torso, 0)
    return ScanProblem(
        FitTask(
            torso,
            target,
            start_from_landmarks(torso, landmarks),
            load_recipe("paper"),
            {},
        ).with_picks(dict(landmarks))
    )


def joint_energy(rig: Rig, x: RigParameters) -> float:
    """Equation 6 on the relative motion at each joint, with the anchor's place on both bones."""
    total = 0.0
    for joint in rig.joints:
        p, c = joint.parent, joint.child
        q_p, q_c = rig.bones[p].rotation, rig.bones[c].rotation
        turned_p, turned_c = x.rotations[p] @ q_p.T, x.rotations[c] @ q_c.T
        at = [
            x.rotations[k] @ (x.scales[k] * (q.T @ (joint.anchor - rig.bones[k].origin))) + x.translations[k]
            for k, q in ((p, q_p), (c, q_c))
        ]
        total += float((log_so3((turned_p.T @ turned_c)[None]) ** 2).sum() + ((CM * (at[0] - at[1])) ** 2).sum())
    return total


@pytest.mark.parametrize("seed", range(3))
def test_its_energy_is_equation_9_of_the_paper(seed: int, torso: Rig, fit: ScanProblem) -> None:
    start = fit.start()
    state = start.retract(0.01 * np.random.default_rng(seed).normal(size=start.dof))
    x = state.x
    stage = fit.task.recipe.stages[0]
    matches = fit.matches(stage, 1.0, state)
    assert len(matches.vertices) > 1000
    vertices = pose(torso, x)
    height = np.einsum("mi,mi->m", matches.normals, vertices[matches.vertices] - matches.points)
    names = tuple(fit.task.landmarks)
    places = torso.landmark_points(names).positions(vertices, torso.faces)
    gaps = places - np.array([fit.task.landmarks[name] for name in names])
    expected = (
        ((CM * height) ** 2).sum() / DATA
        + ((x.scales - 1.0) ** 2).sum() / SCALES
        + (x.weights**2).sum() / SHAPES
        + joint_energy(torso, x) / JOINTS
        + ((CM * gaps) ** 2).sum() / LANDMARKS
    )
    terms = fit.terms(stage, 1.0, state, matches)
    assert 2.0 * fit.energy(terms, state) == pytest.approx(expected, rel=1e-5)


def test_its_residual_has_three_axes_and_the_scans_direction(torso: Rig, fit: ScanProblem) -> None:
    state = fit.start()
    stage = fit.task.recipe.stages[0]
    matches = fit.matches(stage, 1.0, state)
    (data,) = (term for term in fit.terms(stage, 1.0, state, matches).residuals if isinstance(term, PointToPoint))
    residual = data.residual(state).reshape(3, -1).T * fit.task.recipe.observed.skin
    along = np.einsum("mi,mi->m", residual, matches.normals)
    np.testing.assert_allclose(residual, along[:, None] * matches.normals, atol=1e-12)
    moved = BodyState(
        torso, state.x.moved(np.eye(3), np.array([0.001, 0.0, 0.0]))
    )  # the same step costs the same in every direction
    change = data.residual(moved).reshape(3, -1).T * fit.task.recipe.observed.skin - residual
    np.testing.assert_allclose(change, np.tile([0.001, 0.0, 0.0], (len(change), 1)), atol=1e-12)


def test_a_projection_stays_in_the_tangent_plane_and_lies_on_the_normal_through_the_vertex(
    rng: np.random.Generator,
) -> None:
    normals = rng.normal(size=(20, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    vertices, points = rng.normal(size=(50, 3)), rng.normal(size=(20, 3))
    chosen = rng.choice(50, 20, replace=False)
    found = projected(Correspondences(chosen, points, normals, np.zeros(20)), vertices)
    np.testing.assert_allclose(np.einsum("mi,mi->m", found.points - points, normals), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.cross(found.points - vertices[chosen], normals), 0.0, atol=1e-12)


def test_a_preset_with_two_data_terms_in_one_stage_is_refused(tmp_path: Path, repository: Path) -> None:
    text = (repository / "server/breastrig/fitting/presets/paper.toml").read_text("utf-8")
    (tmp_path / "both.toml").write_text(text + "along = 3.0\n", "utf-8")
    with pytest.raises(BadSettings, match=r"stages\.0: .*along stands beside point_to_plane only"):
        load_recipe(tmp_path / "both.toml")


def test_a_packaged_preset_is_read_once_and_a_file_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text((files("breastrig.fitting") / "presets" / "paper.toml").read_text("utf-8"), encoding="utf-8")
    known, preset_text = load_recipe("paper"), recipe.preset_text
    read: list[str] = []

    def noted(name: str) -> str:
        read.append(name)
        return preset_text(name)

    monkeypatch.setattr(recipe, "preset_text", noted)
    assert load_recipe("paper") is known
    assert read == []
    assert load_recipe(mine) == known
    assert read == [recipe.COMMON]
