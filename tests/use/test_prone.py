"""A skin as the segmentation of a breast MRI gives it: the front alone, no arms, turned, in millimetres."""

import json
from pathlib import Path

import numpy as np
import pytest

import breastrig
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.stance_priors import mean_weights

MRI = (
    "suprasternal_notch",
    "mid_sternum",
    "xiphoid",
    "nipple_L",
    "nipple_R",
    "inframammary_fold_L",
    "inframammary_fold_R",
)
TURN = exp_so3(np.array([0.4, 2.1, -1.3]))


@pytest.fixture(scope="module")
def skin() -> tuple[breastrig.Scan, dict[str, np.ndarray]]:
    rig = breastrig.load_model()
    body = rig.template + np.tensordot(mean_weights(rig, "prone"), rig.blendshapes, axes=1)
    breasts = np.concatenate([rig.regions["breast_L"], rig.regions["breast_R"]])
    low = body[breasts].min(axis=0) - np.array([0.03, 0.03, 0.0])
    high = body[breasts].max(axis=0) + np.array([0.03, 0.08, 1.0])
    seen = ((body > low) & (body < high)).all(axis=1) & (vertex_normals(body, rig.faces)[:, 2] > 0.0)
    faces = rig.faces[seen[rig.faces].all(axis=1)]
    places = rig.landmark_points(MRI).positions(body, rig.faces)
    picks = {name: 1e3 * place @ TURN.T for name, place in zip(MRI, places, strict=True)}
    return breastrig.Scan.from_arrays(1e3 * body @ TURN.T, faces, unit="mm"), picks


@pytest.fixture(scope="module")
def prone(
    skin: tuple[breastrig.Scan, dict[str, np.ndarray]],
) -> tuple[breastrig.Fit, dict[str, np.ndarray]]:
    scan, picks = skin
    return breastrig.fit(scan, picks, stance="prone"), picks


def test_a_prone_skin_is_fitted_to_its_landmarks(
    prone: tuple[breastrig.Fit, dict[str, np.ndarray]],
) -> None:
    fit, picks = prone
    assert fit.stance == "prone"
    assert fit.verdict.level in ("good", "check")
    off = {name: float(np.linalg.norm(fit.landmarks[name] - place)) for name, place in picks.items()}
    assert max(off.values()) < 4.0, off
    assert fit.result["model_alone"]["surface_distance_mm"]["mean"] < 2.0
    assert json.loads(fit.files["result.json"])["stance"] == "prone"


def test_a_prone_fit_is_loaded_and_carries_a_lesion_to_itself(
    prone: tuple[breastrig.Fit, dict[str, np.ndarray]], tmp_path: Path
) -> None:
    fit, picks = prone
    fit.save(tmp_path / "prone")
    loaded = breastrig.Fit.load(tmp_path / "prone")
    center = 0.7 * picks["nipple_L"] + 0.3 * picks["xiphoid"]
    item = {"kind": "lesion", "id": "a", "name": "MRI 1", "center": center.tolist(), "radius_mm": 5.0}
    document = breastrig.transfer(fit, loaded, {"schema": "breastrig/plan@1", "items": [item]}).document
    (lesion,) = document["lesions"]
    np.testing.assert_allclose(lesion["center"], center, atol=1.0)
    assert lesion["carried"]


def test_without_landmarks_nipples_and_xiphoid_are_found_by_the_form_of_hanging_breasts(
    skin: tuple[breastrig.Scan, dict[str, np.ndarray]],
) -> None:
    scan, true = skin
    fit = breastrig.fit(scan)
    assert fit.stance == "prone"
    off = {name: float(np.linalg.norm(fit.landmarks[name] - place)) for name, place in true.items()}
    assert max(off["nipple_L"], off["nipple_R"]) < 8.0, off
    assert off["xiphoid"] < 12.0, off
    assert fit.verdict.level in ("good", "check")


def test_sides_that_are_exchanged_are_said_to_be(skin: tuple[breastrig.Scan, dict[str, np.ndarray]]) -> None:
    scan, picks = skin
    other = {"L": "R", "R": "L"}
    wrong = {n[:-1] + other[n[-1]] if n[-2:] in ("_L", "_R") else n: place for n, place in picks.items()}
    fit = breastrig.fit(scan, wrong, stance="prone")
    assert fit.verdict.level in ("check", "unusable")
    assert "exchanged" in " ".join(fit.verdict.reasons)
