"""What is known of a rig stands beside it and is of this very rig: no name makes it another's."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from breastrig.cli.main import main
from breastrig.core.errors import BadModel
from breastrig.fitting.body.refine import hidden_skin, trunk_depth
from breastrig.fitting.uncertainty.radii import calibration
from breastrig.fitting.verdicts.verdict import verdict_limits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.calibration import measure_calibration
from breastrig.rig.body_statistics import body_statistics
from breastrig_studies.output.rig_files import write_rig

TORSO = default_rig_path()


@pytest.fixture
def male(tmp_path: Path) -> Path:
    """Another body by the name of torso, with the torso's numbers beside it."""
    torso = read_rig(TORSO)
    write_rig(replace(torso, template=torso.template * [1.1, 1.05, 1.0]), tmp_path)
    shutil.copytree(TORSO.with_suffix(".known"), tmp_path / "torso.known")
    return tmp_path / "torso.glb"


def test_another_rig_called_torso_has_nothing_of_the_torsos(male: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = read_rig(male)
    assert (rig.name, rig.known) == ("torso", {})
    known = (calibration, verdict_limits, measure_calibration, body_statistics, trunk_depth)
    assert [each(rig) for each in known] == [None] * len(known)
    assert hidden_skin(rig, "supine") is None
    assert main(["model", "info", "--model", str(male)]) == 0
    assert "Not calibrated for this rig: torso.known is of another one" in capsys.readouterr().out
    shutil.rmtree(male.with_suffix(".known"))
    assert main(["model", "check", "--model", str(male)]) == 0
    assert "Not calibrated for this rig: there is no folder torso.known beside it." in capsys.readouterr().out


def test_one_command_binds_what_is_known_and_a_changed_rig_is_another_again(male: Path) -> None:
    assert main(["model", "bind", "--model", str(male)]) == 0
    rig = read_rig(male)
    assert rig.known == read_rig(TORSO).known
    assert calibration(rig) == calibration(read_rig(TORSO))
    side = male.with_suffix(".json")
    side.write_text(side.read_text() + "\n")
    assert read_rig(male).known == {}


def test_a_changed_number_is_read_anew_and_a_damaged_file_is_one_sentence(
    male: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["model", "bind", "--model", str(male)])
    verdict = male.with_suffix(".known") / "verdict.toml"
    assert verdict_limits(read_rig(male)) is not None
    verdict.write_text(verdict.read_text().replace("unusable_at = 2", "unusable_at = 3"))
    limits = verdict_limits(read_rig(male))
    assert limits.unusable_at == 3
    verdict.write_text(verdict.read_text().replace("unusable_at = 3", "unusable_at = 0"))
    with pytest.raises(BadModel, match=r"torso.known/verdict.toml cannot be used: unusable_at: .*\.$"):
        verdict_limits(read_rig(male))
    assert main(["model", "check", "--model", str(male)]) == 2
    verdict.write_text(verdict.read_text().replace("unusable_at = 0", "unusable_at = 3"))
    errors = male.with_suffix(".known") / "landmark_errors.json"
    errors.write_text('{"schema": "breastrig/landmark-errors@1", "stances": {"prone": {"nipple": {"mean_mm": [1]}}}}')
    capsys.readouterr()
    assert main(["model", "check", "--model", str(male)]) == 2
    assert "torso.known/landmark_errors.json cannot be used: stances.prone.nipple.mean_mm" in capsys.readouterr().err
    (male.with_suffix(".known") / "rig.json").write_text("{}")
    assert read_rig(male).known == {}
    assert main(["model", "bind", "--model", str(male)]) == 0
    assert "verdict.toml" in read_rig(male).known
