"""`breastrig evaluate`: what is measured is kept, resumed, measured anew when its input changes, and tabulated."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from breastrig.cli.main import main
from breastrig.evaluation import work
from breastrig.evaluation.cohort import read_cohort
from breastrig.evaluation.questions.scene import read_scene
from breastrig.scan.landmark_files import read_landmarks

QUICK = ["--quick", "--rotations", "1", "--jobs", "1", "--preset", "default"]


def rows(file: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(file.read_text().splitlines()))


def kept(out: Path) -> dict[str, dict[str, Any]]:
    return {file.name: json.loads(file.read_text()) for file in (out / "work").glob("*.json")}


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The labels of the units that are really measured."""
    labels: list[str] = []
    original = work.answered

    def counting(unit: work.Unit) -> dict[str, Any]:
        labels.append(unit.label)
        return original(unit)

    monkeypatch.setattr(work, "answered", counting)
    return labels


def test_finished_work_is_kept_and_a_changed_input_is_measured_anew(
    cohort: Path, tmp_path: Path, counted: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = ["evaluate", str(cohort), *QUICK, "-o", str(out)]
    assert main(command) == 0
    assert "MakeHuman, supine" in capsys.readouterr().out
    questions = {"accuracy", "halves", "no_landmarks", "clicks", "one_wrong", "exchanged_sides", "random_turns"}
    assert sorted(counted) == sorted(f"patient_x-{s}-{q}" for s in ("standing", "supine") for q in questions)
    first = kept(out)
    tables = {file.name: file.read_text() for file in out.glob("*.csv")}

    counted.clear()  # nothing changed: nothing is fitted, everything is the same
    assert main(command) == 0
    assert counted == []
    assert kept(out) == first
    assert {file.name: file.read_text() for file in out.glob("*.csv")} == tables

    next((out / "work").glob("*standing-halves*")).write_text('{"half')  # as after a crash: only this one is missing
    assert main(command) == 0
    assert counted == ["patient_x-standing-halves"]
    assert kept(out) == first

    counted.clear()  # another landmark: all of that case, and nothing of the other
    landmarks = json.loads((cohort / "patient_x/supine/landmarks.json").read_text())
    landmarks["landmarks"]["umbilicus"][1] += 0.002
    (cohort / "patient_x/supine/landmarks.json").write_text(json.dumps(landmarks))
    assert main(command) == 0
    assert sorted(counted) == sorted(f"patient_x-supine-{question}" for question in questions)

    numbers = {(r["case"], r["question"]): r["answer"] for r in kept(out).values() if r not in first.values()}
    numbers |= {(r["case"], r["question"]): r["answer"] for r in first.values() if r["case"] == "standing"}
    for row in rows(out / "table1.csv"):
        if row["note"] != "mean":
            answer = numbers[row["setting"], "accuracy"]
            assert float(row["truth_mean_mm"]) == pytest.approx(answer["truth_mm"]["mean"], rel=1e-4)
            assert float(row["landmarks_max_mm"]) == pytest.approx(answer["landmark_mm"]["max"], rel=1e-4)
            assert float(row["surface_mean_mm"]) < 1.0  # the model's own shape
    for row in rows(out / "landmarks.csv"):
        if row["note"] != "mean":
            expected = numbers[row["setting"], "halves"]["landmarks_mm"]
            assert float(row["half_given_landmarks_mm"]) == pytest.approx(expected, rel=1e-4)
    means = [row for row in rows(out / "turns.csv") if row["note"] == "mean"]
    assert {(row["setting"], row["scan"]) for row in means} == {
        ("standing", "as scanned"),
        ("supine", "as scanned"),
        ("supine", "without table"),
    }


def test_a_failed_fit_is_told_and_the_others_go_on(cohort: Path, tmp_path: Path) -> None:
    place = cohort / "patient_x" / "supine"
    (place / "scan.ply").write_text("ply\nformat ascii 1.0\nend_header\n")  # nothing in it
    out = tmp_path / "out"
    assert main(["evaluate", str(cohort), *QUICK, "--rotations", "0", "-o", str(out)]) == 0
    by_setting = {row["setting"]: row for row in rows(out / "table1.csv") if row["note"] != "mean"}
    assert float(by_setting["standing"]["truth_mean_mm"]) < 1.0
    assert by_setting["supine"]["truth_mean_mm"] == ""
    sentence = by_setting["supine"]["note"]
    assert sentence.endswith(".")
    assert {row["sentence"] for row in rows(out / "failures.csv")} == {sentence}
    assert len(rows(out / "failures.csv")) == 6  # questions
    failed = [record for record in kept(out).values() if record["failed"]]
    assert {record["case"] for record in failed} == {"supine"}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere"], "holds no scans"),
        ([], "COHORT"),
        (["nowhere", "--virtual"], "not both"),
        (["nowhere", "--preset", "fast"], "fast"),
        (["nowhere", "--jobs", "0"], "--jobs"),
        (["nowhere", "--rotations", "-1"], "--rotations"),
        (["nowhere", "--preset", "default", "--preset", "default"], "same name"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = [str(tmp_path / word) if word == "nowhere" else word for word in arguments]
    assert main(["evaluate", *asked, "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_a_pick_along_the_skin_is_on_the_skin_and_as_far_as_asked(cohort: Path, rng: np.random.Generator) -> None:
    scene = read_scene(read_cohort(cohort)[0])
    for name in read_landmarks(cohort / "patient_x/standing/landmarks.json")[0]:
        moved = scene.along_the_skin(scene.landmarks[name], 0.005, rng)
        assert scene.target.search.query(moved[None]).distances[0] < 1e-6
        assert np.linalg.norm(moved - scene.landmarks[name]) == pytest.approx(0.005, abs=0.001)
