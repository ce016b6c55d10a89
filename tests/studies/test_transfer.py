"""The study of carried drawings on patients whose answer is known."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cohort import write_case, write_patient

from breastrig.drawings.skin_maps import skin_map
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies import transfer
from breastrig_studies.studies.other_patient import other_patient
from breastrig_studies.studies.result_cache import Unit, answered
from breastrig_studies.studies.transfer import ALL, PICKS, WAYS, transfer_study

pytestmark = pytest.mark.long

ALL_SIDES = -2.0  # of a normal


@pytest.fixture(scope="module")
def stiff(tmp_path_factory: pytest.TempPathFactory, rig: Rig) -> Path:
    """A patient who lies down without changing at all."""
    folder = tmp_path_factory.mktemp("stiff")
    rest = rest_parameters(rig)
    write_case(folder / "p" / "standing", rig, rest, "standing", behind=ALL_SIDES)
    write_case(
        folder / "p" / "lying",
        rig,
        rest.moved(exp_so3(np.array([-0.3, 0.2, 0.1])), np.ones(3)),
        "supine",
        behind=ALL_SIDES,
    )
    (folder / "p" / "patient.json").write_text(json.dumps({"family": "makehuman"}))
    return folder


@pytest.fixture(scope="module")
def rows(stiff: Path, rig: Rig) -> list[dict[str, Any]]:
    """Of her study.  Skin is not expected to move when somebody lies down, for this patient's does not."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(skin_map, "lying_motion", lambda rig: None)
        patch.setattr(transfer, "STROKES", 50)
        found: list[dict[str, Any]] = transfer_study(read_cohort(stiff), rig, load_recipe("default"))["rows"]
    return found


def test_of_a_patient_who_does_not_change_every_way_with_true_picks_is_right(rows: list[dict[str, Any]]) -> None:
    assert {row["picks"] for row in rows} == set(PICKS)
    assert {row["line"] for row in rows} == {ALL, "lumpectomy", "meridians", "strokes"}
    assert {(row["from"], row["to"]) for row in rows} == {("standing", "lying"), ("lying", "standing")}
    for row in rows:
        if row["picks"] == PICKS[0]:
            assert row["points"] > 0
            assert max(row[way]["mean_mm"] for way in ("skin", "rigid", "spline")) < 0.5
            assert row["model"]["mean_mm"] < 3.0  # two fits in two stances
    whole = [row for row in rows if (row["line"], row["region"]) == (ALL, ALL)]
    assert len(whole) == 2 * len(PICKS)
    for row in whole:
        parts = [part for part in rows if part["region"] != ALL and part["line"] != ALL]
        parts = [part for part in parts if all(part[key] == row[key] for key in ("from", "to", "picks"))]
        assert sum(part["points"] for part in parts) == row["points"]
        for way in WAYS:
            mean = sum(part["points"] * part[way]["mean_mm"] for part in parts) / row["points"]
            assert row[way]["mean_mm"] == pytest.approx(mean, abs=2e-3)


def test_a_wrong_pick_hurts_the_spline_more_than_the_skin(rows: list[dict[str, Any]]) -> None:
    for row in rows:
        if (row["line"], row["region"], row["picks"]) == (ALL, ALL, PICKS[2]):
            assert row["skin"]["mean_mm"] < 0.8 * row["spline"]["mean_mm"]


def test_the_same_body_twice_has_its_shapes_at_the_same_relative_places(tmp_path: Path, rig: Rig) -> None:
    for name in ("p1", "p2"):
        write_patient(tmp_path / name, rig, 3, "makehuman", ("standing",))
    answer = other_patient(read_cohort(tmp_path), rig, load_recipe("default"))
    assert (answer["first"], answer["second"]) == ("p1", "p2")
    assert {row["shape"] for row in answer["rows"]} >= {"breast_L", "breast_R", "meridian_upper_L"}
    for row in answer["rows"]:
        assert row["second"] == pytest.approx(row["first"], abs=0.01)
    meridian = [row for row in answer["rows"] if row["shape"] == "meridian_lower_L" and row["landmark"] == "nipple"]
    assert meridian[0]["first"] < 0.1


@pytest.mark.parametrize("side", ["R"])
def test_a_body_without_a_breast_has_no_answer_and_no_other_body_loses_its_own(
    stiff: Path, tmp_path: Path, side: str
) -> None:
    shutil.copytree(stiff, tmp_path / "cohort")
    for file in (tmp_path / "cohort").glob("p/*/landmarks.json"):
        document = json.loads(file.read_text())
        del document["landmarks"][f"nipple_{side}"]
        file.write_text(json.dumps(document))
    unit = Unit(read_cohort(tmp_path / "cohort"), "transfer", load_recipe("default"), default_rig_path())
    assert answered(unit)["failed"] == f"The body has no nipple_{side}, without which this question has no answer."
