"""`breastrig evaluate`: what is measured is kept, resumed, measured anew when its input changes, and tabulated."""

import csv
import json
import re
import shutil
from collections.abc import Callable, Iterator
from functools import partial, wraps
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import trimesh
from helpers.blank_pictures import blank_pictures
from helpers.cohort import FEW, write_patient

from breastrig.cli.main import main
from breastrig.core.errors import BadInput
from breastrig.rig.model import Rig
from breastrig_studies import command as evaluate_command
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.output import charts, publish
from breastrig_studies.studies import landmarks, plan, registry
from breastrig_studies.studies import result_cache as work
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.sensitivity import TERMS
from breastrig_studies.studies.unseen import CUTS
from breastrig_studies.tables import studies
from breastrig_studies.tables.measures import measures_table, ptosis_table
from breastrig_studies.tables.verdicts import verdicts_table

pytestmark = pytest.mark.long

WHOLE = ["--rotations", "0", "--jobs", "1", "--preset", "default"]
QUICK = ["--quick", "--rotations", "1", "--jobs", "1", "--preset", "default"]
FACTORS = (1.0, 100.0)
MEASURED = ("accuracy", "random_turns")  # by the tests of --quick; the other answers are stood in for


@pytest.fixture(scope="module", autouse=True)
def fewer_fits() -> Iterator[None]:
    """Larger steps, fewer clickings, a free-form peer that stops early, small charts: the same questions."""

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plan, "COUNT_STEP", 55)
        for module in (plan, studies):
            patch.setattr(module, "FACTORS", FACTORS)
        patch.setattr(landmarks, "CLICKERS", 2)
        patch.setattr(registry, "REPEATS", 1)
        patch.setattr(charts, "DPI", 40)
        blank_pictures(patch)
        free_form = partial(trimesh.registration.nricp_amberg, steps=[[0.01, 10, 0.5, 1]])
        patch.setattr(trimesh.registration, "nricp_amberg", free_form)
        yield


def rows(file: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(file.read_text().splitlines()))


def kept(out: Path) -> dict[str, dict[str, Any]]:
    return {file.name: json.loads(file.read_text()) for file in (out / "work").glob("*.json")}


@pytest.fixture
def tables_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """No figures and pictures, which other tests look at."""
    monkeypatch.setattr(publish, "have_plots", lambda: False)
    monkeypatch.setattr(publish, "fit_pictures", lambda *_: [])


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


StandIn = Callable[[str, dict[str, Any]], None]


@pytest.fixture
def stand_in(whole: Path, monkeypatch: pytest.MonkeyPatch) -> StandIn:
    """Gives questions an answer without measuring; at first all but MEASURED have the answers of another patient."""

    def stand_in(question: str, answer: dict[str, Any]) -> None:
        @wraps(work.ANSWERS[question])
        def answering(cases: tuple[Case, ...], *_: Any, **__: Any) -> dict[str, Any]:
            read_scene(cases[0])  # a scan that cannot be read fails as ever
            return answer

        monkeypatch.setitem(work.ANSWERS, question, answering)

    for record in kept(whole).values():
        if record["question"] not in MEASURED:
            stand_in(record["question"], record["answer"])
    return stand_in


@pytest.mark.usefixtures("tables_only")
def test_finished_work_is_kept_and_a_changed_input_is_measured_anew(
    cohort: Path, tmp_path: Path, counted: list[str], stand_in: StandIn, capsys: pytest.CaptureFixture[str]
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

    known = {(r["case"], r["question"]): r["answer"] for r in first.values()}
    stand_in("random_turns", known["supine", "random_turns"])
    stand_in("halves", known["supine", "halves"] | {"landmarks_mm": 1.0 + known["supine", "halves"]["landmarks_mm"]})
    counted.clear()  # another landmark: all of that case, and nothing of the other
    landmarks = json.loads((cohort / "patient_x/supine/landmarks.json").read_text())
    landmarks["landmarks"]["umbilicus"][1] += 0.002
    (cohort / "patient_x/supine/landmarks.json").write_text(json.dumps(landmarks))
    assert main(command) == 0
    assert sorted(counted) == sorted(f"patient_x-supine-{question}" for question in questions)

    anew = [record for name, record in kept(out).items() if name not in first]
    numbers = known | {(r["case"], r["question"]): r["answer"] for r in anew}
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


@pytest.mark.usefixtures("tables_only")
def test_a_failed_fit_is_reported_and_the_others_go_on(
    whole: Path, cohort: Path, tmp_path: Path, stand_in: StandIn
) -> None:
    (measured,) = (r["answer"] for r in kept(whole).values() if r["question"] == "accuracy")
    stand_in("accuracy", measured)
    place = cohort / "patient_x" / "supine"
    (place / "scan.ply").write_text("ply\nformat ascii 1.0\nend_header\n")  # nothing in it
    out = tmp_path / "out"
    assert main(["evaluate", str(cohort), *QUICK, "--rotations", "0", "-o", str(out)]) == 0
    by_setting = {row["setting"]: row for row in rows(out / "table1.csv") if row["note"] != "mean"}
    assert float(by_setting["standing"]["truth_mean_mm"]) == pytest.approx(measured["truth_mm"]["mean"], rel=1e-4)
    assert by_setting["supine"]["truth_mean_mm"] == ""
    sentence = by_setting["supine"]["note"]
    assert sentence.endswith(".")
    assert {row["sentence"] for row in rows(out / "failures.csv")} == {sentence}
    assert len(rows(out / "failures.csv")) == 6  # questions
    failed = [record for record in kept(out).values() if record["failed"]]
    assert {record["case"] for record in failed} == {"supine"}
    assert sentence in (out / "evaluation.md").read_text()

    (cohort / "patient_x" / "standing" / "scan.ply").write_text((place / "scan.ply").read_text())  # now all fail
    assert main(["evaluate", str(cohort), *QUICK, "--rotations", "0", "-o", str(out)]) == 0
    assert {row["truth_mean_mm"] for row in rows(out / "table1.csv")} == {""}
    assert len(rows(out / "failures.csv")) == 12


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere"], "holds no scans"),
        ([], "COHORT"),
        (["nowhere", "--virtual"], "not both"),
        (["nowhere", "--painted"], "--painted alone"),
        (["--painted", "--warped", "3"], "--painted alone"),
        (["--virtual", "--half", "development"], "--half"),
        (["--virtual", "--hanging", "1"], "--hanging is a share"),
        (["--warped", "1", "--hanging", "2"], "--hanging is a share"),
        (["--warped", "1", "--prone"], "--prone needs a COHORT"),
        (["--prone"], "--prone is how warped bodies are scanned"),
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


def test_prone_bodies_that_were_made_are_what_is_measured(
    cohort: Path, rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of those that were asked for, though more may be there."""
    seen: list[str] = []

    def make(folder: Path, progress: Callable[[str], None], data: Path, bodies: int, half: str) -> None:
        for name in ("prone_000_development", "prone_001_validation", "prone_003_validation"):
            write_patient(folder / name, rig, 2, "made", stances=("standing",), names=FEW)

    def measured(plan: plan.Plan, *_: object) -> None:
        seen.extend(case.patient for case in plan.cases)
        raise BadInput("It was seen.")

    monkeypatch.setattr("breastrig_studies.virtual.warped.prone.make_prone", make)
    monkeypatch.setattr(evaluate_command, "measured", measured)
    asked = ["evaluate", str(cohort), "--warped", "3", "--prone", "--half", "validation", "-o", str(tmp_path / "out")]
    assert main(asked) == 2
    assert seen == ["prone_001_validation"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, rig: Rig) -> Path:
    """A run with all studies on one scan, and its folder."""
    folder = tmp_path_factory.mktemp("whole")
    write_patient(folder / "cohort" / "patient_y", rig, 2, "somebody else's", stances=("standing",), names=FEW)
    assert main(["evaluate", str(folder / "cohort"), *WHOLE, "-o", str(folder / "out")]) == 0
    return folder / "out"


def test_the_summary_has_every_table_and_figure_and_tells_no_paths(whole: Path) -> None:
    said = (whole / "evaluation.md").read_text()
    for word in ("Virtual patients", "Research use only", "breastrig evaluate cohort", "| independent"):
        assert word in said
    assert "MakeHuman bodies" not in said  # none are in this cohort
    shown = re.findall(r"^## (.*)$", said, flags=re.MULTILINE)
    assert {file.stem.replace("_", " ").capitalize() for file in whole.glob("*.csv")} == {*shown} - {"Figures"}
    for file in whole.glob("*.csv"):
        assert len(rows(file)) > 0
    pictures = re.findall(r"!\[[^]]*\]\(([^)]*)\)", said)
    assert {*pictures} == {f"figures/{file.name}" for file in (whole / "figures").glob("*.png")}
    assert str(whole.parent) not in said  # a summary that is handed on tells no paths
    assert not re.search(r"\b(None|nan|inf)\b", said)


def test_the_tables_of_the_studies_hold_what_was_measured(whole: Path) -> None:
    found = list(kept(whole).values())
    compliances = {
        (row["compliance"], float(row["factor"])): float(row["surface_mm"]) for row in rows(whole / "compliances.csv")
    }
    for record in (record for record in found if record["question"] == "compliance"):
        term, factor = record["settings"]["term"], record["settings"]["factor"]
        terms = {name for name, _ in compliances} if factor == 1.0 else {term}
        for name in terms:
            assert compliances[name, factor] == pytest.approx(record["answer"]["surface_mm"], rel=1e-4)
    assert len(compliances) == len(FACTORS) * len(TERMS)

    shapes = {(row["order"], int(row["shapes"])): row for row in rows(whole / "blendshapes.csv")}
    assert [count for order, count in shapes if order == "rig"] == [0, 55]
    by_count = {len(r["settings"]["names"]): r["answer"] for r in found if r["question"] == "shape_count"}
    for order in ("rig", "usefulness"):
        for count in (0, 55):  # the same shapes in both orders
            assert float(shapes[order, count]["surface_mm"]) == pytest.approx(by_count[count]["surface_mm"], rel=1e-4)
    assert by_count[55]["surface_mm"] < by_count[0]["surface_mm"]  # the scan was made with them
    order = rows(whole / "blendshape_order.csv")
    moved = [float(row["standing_moved_mm"]) for row in order]
    assert moved == sorted(moved, reverse=True)
    assert len({row["standing_shape"] for row in order}) == 55

    methods = {row["method"]: row for row in rows(whole / "peers.csv")}
    assert set(methods) == {"BreastRig, default", "rigid closest points", "free-form (nricp_amberg)"}
    surfaces = {method: float(row["surface_mm"]) for method, row in methods.items()}
    assert surfaces["BreastRig, default"] < surfaces["rigid closest points"]


def test_without_matplotlib_tables_and_summary_are_still_written(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = shutil.copytree(whole, tmp_path / "out")  # its answers hold for the same files in any folder
    for module in (publish, evaluate_command):
        monkeypatch.setattr(module, "have_plots", lambda: False)
    assert main(["evaluate", str(whole.parent / "cohort"), *WHOLE, "-o", str(out)]) == 0
    assert "pip install breastrig[plots]" in capsys.readouterr().err
    assert kept(out) == kept(whole)
    assert {file.name: file.read_text() for file in out.glob("*.csv")} == {
        file.name: file.read_text() for file in whole.glob("*.csv")
    }
    assert {file.stem for file in (out / "figures").glob("*.png")} == {"fit_independent_best"}
    assert (out / "evaluation.md").read_text().count("![") == 1


@pytest.fixture(scope="module")
def answers(whole: Path) -> dict[str, Any]:
    """Of the questions that are asked once."""
    return {record["question"]: record["answer"] for record in kept(whole).values()}


def record(question: str, answer: dict[str, Any]) -> SimpleNamespace:
    unit = SimpleNamespace(question=question, recipe=SimpleNamespace(name="default"))
    return SimpleNamespace(unit=unit, failed=None, answer=answer)


def test_a_cut_leaves_what_lies_above_it_and_its_fit_is_compared_with_the_whole(answers: dict[str, Any]) -> None:
    numbers = answers["unseen"]
    assert set(numbers) == set(CUTS)
    for of in numbers.values():
        assert of["most_moved_mm"] >= of["moved_mm"] > 0.0
        assert of["smallest_scale"] <= 1.0 <= of["largest_scale"]
    assert numbers["half"]["kept"] == pytest.approx(0.5, abs=0.05)
    assert numbers["nipples"]["kept"] < numbers["navel"]["kept"] < 1.0


def test_certainty_counts_every_landmark_and_every_vertex_of_the_regions(
    whole: Path, answers: dict[str, Any], rig: Rig
) -> None:
    scene, answer = read_scene(read_cohort(whole.parent / "cohort")[0]), answers["certainty"]
    assert set(answer) == {"exact", "clicked", "half"}
    marks = sum(total for _, total in answer["exact"]["landmarks"].values())
    assert marks == len(scene.landmarks)
    skin = sum(total for _, total in answer["exact"]["skin"].values())
    assert skin == sum(map(len, rig.regions.values()))
    assert answer["exact"]["lines"].keys() == {"breasts, across the line"}
    for trial in answer.values():
        for *held_by_level, total in trial["levels"].values():
            assert held_by_level == sorted(held_by_level)
            assert held_by_level[-1] <= total
        of_90 = sum(counts[2] for group, counts in trial["levels"].items() if group.startswith("landmarks"))
        assert of_90 == sum(good for good, _ in trial["landmarks"].values())
        assert trial["dropped"] == 0, "right picks are believed"
        for part in ("landmarks", "skin"):
            assert all(0 <= good <= total for good, total in trial[part].values())


def test_measures_are_compared_with_those_of_the_true_surface(answers: dict[str, Any]) -> None:
    answer = answers["measures"]
    straight = {row[0]: row for row in answer["exact"] if row[1] == "straight"}
    _, _, unit, true, found, low, high = straight["notch_nipple"]
    assert unit == "mm"
    assert found == pytest.approx(true, abs=1e-6)  # between true picks
    assert low < true < high
    (apart,) = (row for row in answer["none"] if row[:2] == ["notch_nipple", "straight, left - right"])
    assert apart[5] < apart[3] < apart[6]
    grades = {row[0] for row in answer["exact"]} - {row[0] for row in answer["none"]}
    assert grades == {"nipple_above_fold", "lowest_point_above_fold", "ptosis"}  # of a nipple that somebody knows
    table = measures_table([record("measures", answer)])
    names = [column.name for column in table.columns]
    assert "ptosis" not in {row.cells[0] for row in table.rows}
    for row in table.rows:
        cells = dict(zip(names, row.cells, strict=True))
        assert (cells["none_error"] is None) == (cells["measure"] in grades)
        assert cells["exact_held"] in (0.0, 50.0, 100.0)
    (row,) = (row for row in ptosis_table([record("measures", answer)]).rows if row.cells[0] == "exact picks")
    assert row.cells[1:4] == ("none", 2, 100.0)


def test_a_right_fit_is_distinguished_from_one_that_is_head_down(answers: dict[str, Any]) -> None:
    answer = answers["verdicts"]
    assert answer["whole"]
    fits = answer["fits"]
    assert fits["landmarks"]["error_mm"] < 5.0
    assert fits["head_down"]["error_mm"] > 150.0
    assert fits["head_down"]["level"] != "good"
    assert fits["head_down"]["reasons"]
    table = verdicts_table([record("verdicts", answer)])
    found = {row.cells[0]: row.cells[1:] for row in table.rows}
    assert found["head down"][:3] == ("whole", "wrong", 1)
    assert found["landmarks given"][:3] == ("whole", "right", 1)
    for row in found.values():
        assert sum(share for share in row[3:] if isinstance(share, float)) == pytest.approx(100.0)
