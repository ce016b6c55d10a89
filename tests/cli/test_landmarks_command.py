"""`breastrig landmarks`: proposals on the example patient, both stances."""

import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from helpers.label_maps import above_navel, front_labels, in_lps, nifti

from breastrig.cli import landmarks_command
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.landmarks.landmark_files import landmark_confidences, read_landmarks
from breastrig.use.landmarks import Proposal, Proposals, propose_landmarks

EXAMPLE = asset_folder("example")


@pytest.mark.slow
@pytest.mark.parametrize("stance", ["standing", "supine"])
def test_all_landmarks_are_proposed_near_their_places_and_sides_are_right(stance: str, tmp_path: Path) -> None:
    assert main(["landmarks", str(EXAMPLE / stance / "scan.ply"), "-o", str(tmp_path / "guess.json")]) == 0
    found, unit = read_landmarks(tmp_path / "guess.json")
    true, true_unit = read_landmarks(EXAMPLE / stance / "landmarks.json")
    per_mm = {"m": 1e3, "mm": 1.0}
    gap = {n: np.linalg.norm(per_mm[str(unit)] * found[n] - per_mm[str(true_unit)] * true[n]) for n in true}
    assert set(found) == set(read_rig(default_rig_path()).landmark_names) >= set(true)
    assert np.mean(list(gap.values())) < 20.0
    assert max(gap[name] for name in ("nipple_L", "nipple_R", "mid_sternum", "xiphoid")) < 25.0
    confidence = json.loads((tmp_path / "guess.json").read_text())["confidence"]
    assert all(0.0 <= value <= 1.0 for value in confidence.values())
    assert confidence["nipple_L"] > confidence["umbilicus"]
    error = json.loads((tmp_path / "guess.json").read_text())["error_mm"]
    assert set(error) == set(found)
    assert sum(gap[name] <= error[name] for name in true) >= 11  # of twelve, at 90 %
    assert max(gap[name] / error[name] for name in true) < 2.0  # none is far beyond its label


def test_what_an_mri_does_not_show_is_not_proposed_and_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its field of view ends above the navel, and before the shoulders; of what is proposed there the error is said."""
    rig = read_rig(default_rig_path())
    whole, start, size = front_labels(rig, rig.template.mean(axis=0), 0.0, 3.0)
    labels, low = above_navel(whole, start, size)
    mri = tmp_path / "mri.nii.gz"
    mri.write_bytes(gzip.compress(nifti(labels, low=low, sizes=np.full(3, size))))
    made: list[Proposals] = []
    monkeypatch.setattr(
        landmarks_command,
        "propose_landmarks",
        lambda *given, **more: made.append(propose_landmarks(*given, **more)) or made[0],
    )
    assert main(["landmarks", str(mri), "--units", "mm", "-o", str(tmp_path / "guess.json")]) == 0
    [proposals] = made
    unseen = "The scan shows no skin where it is expected."
    unsure = "It may lie more than 100 mm from where it is expected."
    missing = dict(proposals.not_proposed)
    assert missing["umbilicus"] == unseen
    assert set(missing.values()) <= {unseen, unsure}
    assert {"nipple_L", "nipple_R"} < set(proposals)
    assert {*proposals, *missing} == set(rig.landmark_names)
    assert all(each.on_scan and each.error is not None and each.error <= 100.0 for each in proposals.values())
    true = dict(zip(rig.landmark_names, in_lps(rig.landmark_points().positions(rig.template, rig.faces)), strict=True))
    held = [np.linalg.norm(each.point - true[name]) <= each.error for name, each in proposals.items()]
    assert np.mean(held) >= 0.9
    document = json.loads((tmp_path / "guess.json").read_text())
    assert (set(document["landmarks"]), document["not_proposed"]) == (set(proposals), missing)
    said = capsys.readouterr().err
    for sentence in set(missing.values()):
        names = ", ".join(name for name, why in missing.items() if why == sentence)
        assert f"breastrig: not proposed: {names}. {sentence}" in said


def test_a_wrong_ending_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["landmarks", str(EXAMPLE / "standing" / "scan.ply"), "-o", str(tmp_path / "guess.doc")]
    assert main(arguments) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(("ending", "says"), [("json", ""), ("csv", "check each"), ("mrk.json", "check each")])
def test_a_file_without_confidences_says_that_its_points_count_as_picked(
    ending: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    guess = Proposals({"xiphoid": Proposal(np.array([0.0, 1.0, 2.0]), 0.3, True, 0.02)}, {})
    monkeypatch.setattr(landmarks_command, "propose_landmarks", lambda *_, **__: guess)
    out = tmp_path / f"guess.{ending}"
    assert main(["landmarks", str(EXAMPLE / "standing" / "scan.ply"), "-o", str(out)]) == 0
    error = capsys.readouterr().err
    assert (says in error, error.count("\n")) == (True, 1 if says else 0)
    assert landmark_confidences(out) == ({"xiphoid": 0.3} if ending == "json" else {})
