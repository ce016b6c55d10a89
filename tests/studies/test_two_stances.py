"""Points carried between the stances of a patient made with the rig, whose true places are known."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from studies.conftest import write_case

from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.fitting.recipe import load_recipe
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.two_stances import by_models, gain

WAYS = [f"{smooth}{fits}_mm" for smooth in ("", "smooth_") for fits in ("separate", "together", "alike")]


@pytest.fixture
def one_body(tmp_path: Path, rig: Rig) -> Path:
    """One body of the rig standing, and lying with other soft tissue."""
    rng = np.random.default_rng(4)
    sigma = np.array([shape.sigma for shape in rig.shapes])
    body = np.array([shape.kind == "body" for shape in rig.shapes])
    gravity = np.array([shape.kind == "gravity" for shape in rig.shapes])
    limits = [shape.min for shape in rig.shapes], [shape.max for shape in rig.shapes]
    shared = 0.5 * sigma * rng.normal(size=len(sigma))
    for stance in ("standing", "supine"):
        own = 0.3 * sigma * rng.normal(size=len(sigma))
        weights = np.where(body, shared, np.where(gravity, 0.8 * (stance == "supine"), own))
        write_case(
            tmp_path / "cohort" / "patient_y" / stance,
            rig,
            replace(rest_parameters(rig), weights=np.clip(weights, *limits)),
            stance,
        )
    (tmp_path / "cohort" / "patient_y" / "patient.json").write_text(json.dumps({"family": "makehuman"}))
    return tmp_path / "cohort"


def test_every_ordered_pair_is_measured_and_one_body_helps_where_there_is_one(one_body: Path, rig: Rig) -> None:
    told: list[str] = []
    rows = gain(read_cohort(one_body), rig, load_recipe("default"), told.append)
    assert [(row["from"], row["to"]) for row in rows] == [("standing", "supine"), ("supine", "standing")]
    assert told == ["patient_y: standing and supine"]
    for row in rows:
        assert row["family"] == "makehuman"
        assert row["points"] > 500
        for picks in (row, row["clicks"]):
            for way in WAYS:
                assert 0.0 < picks[way]["mean"] < picks[way]["p95"]
            assert picks["together_mm"]["mean"] < picks["separate_mm"]["mean"]  # the truth has one body
            assert picks["smooth_together_mm"]["mean"] < picks["rigid_mm"]
            assert picks["smooth_together_mm"]["mean"] < picks["spline_mm"]
        assert row["together_mm"]["mean"] < 3.0
        assert row["smooth_together_mm"]["mean"] < 5.0


def test_perfect_fits_carry_points_to_their_true_places(one_body: Path, rig: Rig) -> None:
    scenes = [read_scene(case) for case in read_cohort(one_body)]
    fits = [FittedScan(scene.target, scene.truth.vertices, {}, scene.case.stance) for scene in scenes]
    chosen = rig.regions["breast_L"]
    found = by_models(rig, fits[0], fits[1], fits[0].vertices[chosen])
    np.testing.assert_allclose(found, fits[1].vertices[chosen], atol=1e-6)


def test_without_the_true_surface_nothing_is_measured(one_body: Path, rig: Rig) -> None:
    (one_body / "patient_y" / "supine" / "truth.ply").unlink()
    assert gain(read_cohort(one_body), rig, load_recipe("default"), lambda _: None) == []
