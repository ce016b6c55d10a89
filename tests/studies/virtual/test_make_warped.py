"""Warped bodies as files: read as a cohort, byte for byte the same again, independent of each other, parts cut."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from breastrig.cli.main import main
from breastrig.core.errors import BadInput
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.case_files import write_case, write_json
from breastrig_studies.virtual.scan import SimulatedScan
from breastrig_studies.virtual.warped import make as make_module
from breastrig_studies.virtual.warped import make_warped
from breastrig_studies.virtual.warped.sources import read_sources

pytestmark = pytest.mark.long


def test_two_of_five_bodies_of_each_half_are_independent_where_there_are_such_sources() -> None:
    sources = read_sources()
    sources = (*sources, *(replace(s, name="other_" + s.name, family="independent") for s in sources[:2]))
    for half in (0, 1):
        drawn = [make_module.source_of(sources, n, np.random.default_rng(n)) for n in range(half, 100, 2)]
        assert sum(source.family == "independent" for source in drawn) == 20
        assert {source.half for source in drawn} == {("development", "validation")[half]}


def test_a_patients_folder_is_read_back_into_body_coordinates(tmp_path: Path, rng: np.random.Generator) -> None:
    """A cohort's woman written as another's case: turned, shifted, in mm and m, and with the independent family."""
    source = read_sources()[1]
    lying = source.lying[0]
    away = np.array([0.0, 0.9, -0.1])  # body coordinates of others begin elsewhere
    for stance, vertices, unit in (("standing", source.standing, "mm"), ("supine", lying.vertices, "m")):
        places = {name: at + away for name, at in source.landmarks(vertices).items()}
        body = VirtualBody(stance, vertices + away, places, None)
        scan = SimulatedScan(vertices[:100], source.faces[:0], 0.0)
        write_case(tmp_path / "patient_c" / stance, body, source.faces, scan, unit, rng, {})
    write_json(tmp_path / "patient_c" / "patient.json", {"family": "vitruvian", "origin": "elsewhere"})
    found = read_sources(tmp_path)[-1]
    assert (found.name, found.half, found.family) == ("patient_c", "development", "independent")
    np.testing.assert_allclose(found.standing, source.standing, atol=2e-6)
    np.testing.assert_allclose(found.lying[0].vertices, lying.vertices, atol=2e-6)
    assert found.lying[0].table == pytest.approx(lying.table, abs=0.003)
    places = source.landmarks(source.standing)
    for name, place in found.landmarks(found.standing).items():
        np.testing.assert_allclose(place, places[name], atol=3e-6)
    assert 0.85 < found.scanned.mean() < 0.99
    assert np.abs(found.standing[~found.scanned, 0]).min() > 0.18  # only the arms' ends


def test_a_folder_without_known_patients_is_refused_with_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="patient_a"):
        make_warped(tmp_path / "out", lambda _: None, tmp_path, bodies=1)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--warped", "0"], "--warped must be"),
        (["--warped", "3", "--virtual"], "not both"),
        (["--half", "development"], "--warped N"),
        (["nowhere", "--warped", "1"], "patient_a"),
    ],
)
def test_wrong_options_are_one_sentence(
    arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = [str(tmp_path / word) if word == "nowhere" else word for word in arguments]
    assert main(["evaluate", *asked, "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
