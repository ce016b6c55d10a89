"""Pairs of marks by colour, through Python and the command line; what is not taken, each in a sentence."""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.example_fits import STANCES, write_example_fits
from helpers.marked_example import MarkedScan, marked_example, of_scan

import breastrig
from breastrig.cli import marks_command
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadInput, BadScan

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example's two fits, as if made of marked scans, which lie beside them."""
    folder = tmp_path_factory.mktemp("marked")
    write_example_fits(folder)
    return folder


@pytest.fixture(scope="module")
def scans(folder: Path) -> dict[str, MarkedScan]:
    found = {stance: marked_example(breastrig.Fit.load(folder / stance), stance) for stance in STANCES}
    for stance, scan in found.items():
        of_scan(folder / stance, scan.content)
        (folder / f"{stance}.zip").write_bytes(scan.content)
    return found


def test_the_marks_of_both_scans_are_proposed_in_pairs_and_written(
    folder: Path,
    scans: dict[str, MarkedScan],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answers = list[breastrig.ProposedMarks]()
    monkeypatch.setattr(
        marks_command,
        "propose_marks",
        lambda *given, **said: answers.append(breastrig.propose_marks(*given, **said)) or answers[0],
    )
    fits, files = [str(folder / stance) for stance in STANCES], [str(folder / f"{stance}.zip") for stance in STANCES]
    out = tmp_path / "marks.json"
    assert main(["marks", *files, "--from", fits[0], "--to", fits[1], "-o", str(out)]) == 0
    said = capsys.readouterr().out
    assert said.endswith(": 4 pairs are proposed; check each.\n")
    document = json.loads(out.read_text())
    assert document["pairs"].keys() == {"m1", "m2", "m3", "m4"}
    [found] = answers
    assert found.says == said.strip() == document["says"]
    mm = [1e3 * breastrig.Fit.load(fit).metres_per_unit for fit in fits]
    for mark in found:
        gaps = [
            each * np.linalg.norm(scans[stance].places - place, axis=1)
            for each, stance, place in zip(mm, STANCES, (mark.source, mark.target), strict=True)
        ]
        assert gaps[0].argmin() == gaps[1].argmin()
        assert max(gap.min() for gap in gaps) < 1.0
        assert mark.kind == ("dot" if gaps[0].argmin() % 2 else "mole")
        assert document["from"]["marks"][mark.name] == pytest.approx(mark.source.tolist())
        assert document["to"]["marks"][mark.name] == pytest.approx(mark.target.tolist())
        assert mark.off_mm < mark.error_mm


def test_another_scan_a_predicted_body_or_a_scan_without_colour_is_one_sentence(
    folder: Path, scans: dict[str, MarkedScan]
) -> None:
    fits, files = [folder / stance for stance in STANCES], [folder / f"{stance}.zip" for stance in STANCES]
    with pytest.raises(BadInput, match="The standing fit was made of another scan than the one given"):
        breastrig.propose_marks(*fits, files[1], files[1])
    predicted = breastrig.predict(fits[0], "supine")
    with pytest.raises(BadInput, match="The supine body is predicted"):
        breastrig.propose_marks(fits[0], predicted, files[0], files[0])
    plain = asset_folder("example") / "standing" / "scan.ply"
    of_scan(folder / "standing", plain.read_bytes())
    with pytest.raises(BadScan, match="too coarse"):
        breastrig.propose_marks(*fits, plain, files[1])
    of_scan(folder / "standing", scans["standing"].content)
