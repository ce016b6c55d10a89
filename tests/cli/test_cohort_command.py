"""`breastrig cohort`: from folders of fits to a prior, and a fit with it."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
from helpers.fake_women import prior_of
from helpers.results import result_document

from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.files.result import BODY, RESULT, ResultFile
from breastrig.fitting.posterior import built_in
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import read_prior
from breastrig.use.folder.cohort import cohort_in, cohort_of_folders

RIG = read_rig(default_rig_path())


def write_fit(folder: Path, seed: int, code: str = "", seen: float = 0.9, **changes: object) -> Path:
    """What a cohort reads of a fit; all women are alike in ten directions."""
    own = built_in(RIG, "standing")
    assert own is not None
    rng = np.random.default_rng(seed)
    away = rng.standard_normal(len(own.mean)) + 3.0 * (np.arange(len(own.mean)) < 10)
    mean = own.mean + seen * np.linalg.cholesky(own.covariance) @ away
    upper = ((1.0 - seen) * own.covariance)[np.triu_indices(len(own.mean))]
    folder.mkdir(parents=True)
    (folder / BODY).write_bytes(np.concatenate([mean, upper]).astype("<f4").tobytes())
    model = {"name": RIG.name, "sha256": RIG.sha256}
    patient = {"patient": {"code": code, "given": True}} if code else {}
    scan = {"sha256": hashlib.sha256(str(seed).encode()).hexdigest()}
    document = result_document(model=model, scan=scan, **patient) | changes
    (folder / RESULT).write_bytes(ResultFile.model_validate(document).content())
    return folder


def cohort(*words: object) -> int:
    return main(["cohort", *map(str, words)])


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cohort") / "results"
    for seed in range(30):
        write_fit(folder / f"woman_{seed}", seed)
    return folder


def test_learn_merge_remove_and_info_agree(results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole, first, second, left = (tmp_path / f"{name}.json" for name in ("whole", "first", "second", "left"))
    some = [results / f"woman_{seed}" for seed in range(5)]
    assert cohort("learn", results, "-o", whole) == 0
    assert cohort("learn", *some, "-o", first) == 0
    assert cohort("remove", whole, *some, "-o", second) == 0
    assert cohort("merge", second, first, "-o", left) == 0
    assert left.read_bytes() == whole.read_bytes()
    assert read_prior(second).women == 25
    assert cohort("remove", second, some[0], "-o", left, "--force") == 2
    assert "not in the prior" in capsys.readouterr().err
    assert cohort("learn", some[0], "-o", first, "--force") == 0
    for prior, said in (
        (whole, "30 standing patients: predicts the next such patient "),
        (second, "25 standing patients: not used, fewer than 30"),
        (first, "1 standing patient: not used, fewer than 30"),
    ):
        assert cohort("info", prior) == 0
        assert f"\n{said}" in capsys.readouterr().out


def test_a_file_of_sums_names_nobody(results: Path, tmp_path: Path) -> None:
    assert cohort("learn", results, "-o", tmp_path / "p.json") == 0
    document = json.loads((tmp_path / "p.json").read_text())
    assert set(document) == {"schema", "notice", "rig", "bones", "shapes", "stances"}
    assert set(document["stances"]["standing"]) == {*("women", "means", "products", "covariances", "scans")}
    assert hashlib.sha256(b"3").hexdigest() not in json.dumps(document)  # of a scan's file, as result.json has it
    assert "woman_" not in (tmp_path / "p.json").read_text()


def test_a_patient_counts_once_in_a_stance_by_the_scan_that_shows_most(tmp_path: Path) -> None:
    for place, seed, seen in (("a", 1, 0.3), ("b", 2, 0.9), ("c", 3, 0.5)):
        write_fit(tmp_path / place, seed, "P 7", seen)
    write_fit(tmp_path / "d", 4, predicted=True)
    write_fit(tmp_path / "e", 5, verdict={"level": "unusable", "reasons": []})
    (write_fit(tmp_path / "f", 6) / BODY).unlink()
    found = cohort_of_folders([tmp_path], RIG)
    alone = cohort_of_folders([tmp_path / "b"], RIG)
    assert found.prior.content() == alone.prior.content()
    assert [sentence.split()[0] for sentence in found.others] == ["2", "2", "1", "3"]
    assert "of an earlier version" in found.others[-1]


def test_what_says_nothing_is_refused_in_one_sentence(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_fit(tmp_path / "other" / "fit", 1, model={"name": "other", "sha256": "0" * 64} | MODEL)
    (tmp_path / "empty").mkdir()
    (tmp_path / "no.json").write_text("{}")
    for words, why in (
        (("learn", tmp_path / "other", "-o", tmp_path / "p.json"), "another model"),
        (("learn", tmp_path / "empty", "-o", tmp_path / "p.json"), "no fit in empty"),
        (("learn", results, "-o", results / "p.json"), "beside"),
        (("merge", tmp_path / "no.json", "-o", tmp_path / "p.json"), "is no prior"),
        (("info", tmp_path / "gone.json"), "cannot be read"),
    ):
        assert cohort(*words) == 2
        said = capsys.readouterr().err
        assert why in said
        assert said.count("\n") == 1
    assert not (tmp_path / "p.json").exists()


MODEL = {"vertices": 1, "bones": 1, "blendshapes": 1}


def test_a_fit_refuses_a_prior_that_is_not_for_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from dataclasses import replace

    from breastrig.core.assets import asset_folder

    scan = asset_folder("example") / "standing" / "scan.ply"
    right, wrong = tmp_path / "right.json", tmp_path / "wrong.json"
    right.write_bytes(prior_of(2).content())
    wrong.write_bytes(replace(prior_of(2), rig_sha256="0" * 64).content())
    for more, why in (
        (["--prior", wrong], "another rig"),
        (["--prior", right, "--preset", "paper"], "leave the prior out"),
        (["--prior", tmp_path / "gone.json"], "cannot be read"),
    ):
        assert main(["fit", str(scan), *map(str, more), "-o", str(tmp_path / "out")]) == 2
        said = capsys.readouterr().err
        assert why in said
        assert said.count("\n") == 1
        assert not (tmp_path / "out").exists()


def test_a_scan_counts_once_under_however_many_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One scan under 32 codes was 32 patients, enough for a prior to be used."""
    scan = {"vertices": 1, "triangles": 1, "unit": "mm", "sha256": "ef" * 32}
    for number in range(32):
        write_fit(tmp_path / "fits" / f"{number}", 1, f"P {number}", scan=scan)
    assert cohort("learn", tmp_path / "fits", "-o", tmp_path / "p.json") == 0
    assert read_prior(tmp_path / "p.json").women == 1
    assert "31 left out: the same scan again." in capsys.readouterr().err


def test_the_example_never_counts_and_can_be_taken_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sha256 = hashlib.sha256((asset_folder("example") / "standing" / "scan.ply").read_bytes()).hexdigest()
    scan = {"vertices": 1, "triangles": 1, "unit": "m", "sha256": sha256}
    example, other = write_fit(tmp_path / "fits" / "a", 1, scan=scan), write_fit(tmp_path / "fits" / "b", 2)
    assert cohort("learn", tmp_path / "fits", "-o", tmp_path / "p.json") == 0
    assert read_prior(tmp_path / "p.json").women == 1
    assert "1 left out: the package's example" in capsys.readouterr().err
    assert cohort("learn", example, "-o", tmp_path / "none.json") == 2
    alone = cohort_in([other], RIG).prior
    earlier = alone.plus(cohort_in([example], RIG, with_example=True).prior)  # of a version that counted it
    (tmp_path / "earlier.json").write_bytes(earlier.content())
    assert cohort("remove", tmp_path / "earlier.json", example, "-o", tmp_path / "left.json") == 0
    assert (tmp_path / "left.json").read_bytes() == alone.content()


def test_merging_counts_nobody_twice(results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole, some, others, out = (tmp_path / f"{name}.json" for name in ("whole", "some", "others", "out"))
    assert cohort("learn", results, "-o", whole) == 0
    assert cohort("learn", *(results / f"woman_{seed}" for seed in range(12)), "-o", some) == 0
    assert cohort("learn", *(results / f"woman_{seed}" for seed in range(10, 20)), "-o", others) == 0
    for priors, counted in (((whole, whole), 30), ((some, whole), 12), ((whole, others, some), 10)):
        assert cohort("merge", *priors, "-o", out, "--force") == 0
        assert out.read_bytes() == whole.read_bytes()
        assert f"{counted} of these scans are in both priors and count once." in capsys.readouterr().err
    assert cohort("merge", some, others, "-o", tmp_path / "no.json") == 2
    assert "Both priors hold 2 of the same scans" in capsys.readouterr().err
    assert not (tmp_path / "no.json").exists()


def test_priors_of_earlier_versions_have_no_hashes_and_it_is_said(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    priors = []
    for number in (0, 1):
        document = json.loads(cohort_in([results / f"woman_{number}"], RIG).prior.content())
        assert len(document["stances"]["standing"].pop("scans")) == 1
        priors.append(tmp_path / f"{number}.json")
        priors[-1].write_text(json.dumps(document))
    assert cohort("merge", *priors, "-o", tmp_path / "both.json") == 0
    assert "has no hashes of its scans" in capsys.readouterr().err
    assert read_prior(tmp_path / "both.json").women == 2
    assert cohort("merge", priors[0], priors[0], "-o", tmp_path / "same.json") == 0  # the same file is known
    assert read_prior(tmp_path / "same.json").women == 1
    assert cohort("remove", tmp_path / "both.json", results / "woman_1", "-o", tmp_path / "left.json") == 0
    assert json.loads((tmp_path / "left.json").read_text()) == json.loads(priors[0].read_text())
