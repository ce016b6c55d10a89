"""Radii of one fit are the same by every door and in every unit: result.json, files, programs, lines, measures."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.forearm import write_forearm

import breastrig
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.line_error import ACROSS
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.gltf.known_files import bind_known
from breastrig.gltf.read_rig import read_rig
from breastrig.report.stance import places
from breastrig.rig.skinning import pose
from breastrig.use.folder.fit_folder import _radii
from breastrig.use.reports.report import stance_of

TIMES = 2.0  # of all deviations
STATES = ("given", "others", "alone", "proposed", "seen", "hidden", "seen_alone", "hidden_alone")
SCATTER = """
expected_scatter = 1.0
freedom_given = 1e9
freedom_elsewhere = 1e9
[without_picks]
clear = 0.2
unclear = 0.1
astray = 0.02
"""


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> dict[str, breastrig.Fit]:
    """Of one forearm, in several units, with an incision."""
    folder = tmp_path_factory.mktemp("arm")
    glb, scan, landmarks = write_forearm(folder)
    known = glb.with_suffix(".known")
    known.mkdir()
    factors = {"standing": {state: {"other": TIMES} for state in STATES}}
    (known / "radii.json").write_text(json.dumps({"stances": factors}))
    (known / "uncertainty.toml").write_text(SCATTER)
    bind_known(glb, read_rig(glb).sha256)
    found, mesh = {}, trimesh.load(scan, process=False)
    for unit in ("mm", "in"):
        times = 1e-3 / METRES_PER_UNIT[unit]
        scaled = folder / f"{unit}.ply"
        trimesh.Trimesh(times * mesh.vertices, mesh.faces, process=False).export(scaled)
        found[unit] = breastrig.fit(breastrig.read_scan(scaled, unit), landmarks, model=glb, drawing="incision")
    return found


def test_the_unit_of_the_scan_changes_no_radius(fits: dict[str, breastrig.Fit]) -> None:
    wanted = fits["mm"]
    said = wanted.result["landmark_uncertainty_mm"]
    assert 0.1 < min(said.values()) < max(said.values()) < 30.0
    assert wanted.uncertainty.shape == (len(wanted.vertices),)
    for fit in fits.values():
        assert fit.result["landmark_uncertainty_mm"] == pytest.approx(said, rel=0.02, abs=0.02)
        assert fit.result["line_error_mm"] == pytest.approx(wanted.result["line_error_mm"], abs=0.11)
        in_mm = 1e3 * fit.metres_per_unit * fit.uncertainty
        assert in_mm == pytest.approx(wanted.uncertainty, rel=0.02)


def test_what_is_proposed_has_the_same_radii_in_every_unit(fits: dict[str, breastrig.Fit], tmp_path: Path) -> None:
    found = {}
    for unit in ("mm", "in"):
        fit = fits[unit]
        file = tmp_path / f"{unit}.ply"
        trimesh.Trimesh(fit.scan_vertices, fit.scan_faces, process=False).export(file)
        found[unit] = breastrig.propose_landmarks(breastrig.read_scan(file, unit), model=fit.model)
    for name, each in found["mm"].items():
        other = found["in"][name]
        assert each.error is not None
        assert 25.4 * other.error == pytest.approx(each.error, rel=0.05)


def test_a_landmark_at_a_vertex_has_the_radius_of_that_vertex(fits: dict[str, breastrig.Fit]) -> None:
    """All factors are alike here, so that landmarks, vertices and the posterior's samples say one thing."""
    fit = fits["mm"]
    at = fit.model.landmark_points()
    vertices = fit.model.faces[at.faces, at.barycentric.argmax(axis=1)]
    radii = dict(zip(fit.model.landmark_names, fit.uncertainty[vertices], strict=True))
    assert fit.result["landmark_uncertainty_mm"] == pytest.approx(radii, rel=1e-3, abs=0.01)
    rng, moved = np.random.default_rng(1), []
    at_mean = pose(fit.model, fit.posterior.in_metres)
    for _ in range(300):
        moved.append(fit.model.pose(fit.posterior.sample(rng)) - at_mean)
    spread = np.sqrt((np.array(moved) ** 2).sum(axis=2).mean(axis=0))
    assert np.median(1e-3 * fit.uncertainty / (TIMES * spread)) == pytest.approx(1.0, abs=0.05)


def test_lines_have_the_radii_of_the_model_under_them(fits: dict[str, breastrig.Fit]) -> None:
    for fit in fits.values():
        document = json.loads(fit.files["drawing.json"])
        (shape,) = document["shapes"]
        search = ClosestPointSearch(fit.vertices, fit.model.faces)
        nearest = search.query(np.array(shape["points"]))
        radii = 1e3 * fit.metres_per_unit * fit.uncertainty
        wanted = np.einsum("mc,mc->m", nearest.barycentric, radii[fit.model.faces[nearest.faces]])
        assert shape["error_mm"] == pytest.approx(wanted, rel=1e-3, abs=2e-3)


def test_the_error_of_lines_is_the_spread_of_what_is_seen_across_them(fits: dict[str, breastrig.Fit]) -> None:
    fit = fits["mm"]  # the scan shows all of it
    wanted = ACROSS * np.sqrt(np.mean(fit.uncertainty**2))
    assert fit.result["line_error_mm"] == pytest.approx(wanted, abs=0.06)


def test_what_is_saved_loaded_and_measured_has_the_same_radii(fits: dict[str, breastrig.Fit], tmp_path: Path) -> None:
    for unit, fit in fits.items():
        fit.save(tmp_path / unit)
        loaded = breastrig.Fit.load(tmp_path / unit, fit.model)
        assert loaded.uncertainty == pytest.approx(fit.uncertainty, rel=1e-6)
        for each in (fit, loaded):
            stance = stance_of(each.in_metres)
            assert stance.radii / each.metres_per_unit == pytest.approx(fit.uncertainty, rel=1e-6)
            radii = {name: place.radius for name, place in places(stance).items()}
            said = {name: 1e-3 * mm for name, mm in fit.result["landmark_uncertainty_mm"].items()}
            assert radii == pytest.approx(said)


@pytest.mark.parametrize("content", [b"", b"\0" * 12, "nan", "negative"])
def test_radii_that_are_none_are_not_known(content: bytes | str, fits: dict[str, breastrig.Fit]) -> None:
    fit = fits["mm"]
    numbers = fit.uncertainty.astype("<f4")
    assert _radii(numbers.tobytes(), fit.model) == pytest.approx(1e-3 * fit.uncertainty, rel=1e-6)
    if isinstance(content, str):
        numbers[7] = np.nan if content == "nan" else -1.0
        content = numbers.tobytes()
    assert _radii(content, fit.model) is None
