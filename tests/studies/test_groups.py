"""Numbers are estimated from the development women: those of the validation and the test set are not read."""

import json
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from breastrig.gltf.read_rig import default_rig_path
from breastrig.rig.model import Rig
from breastrig_studies import landmark_errors, learn, lying_motion, radii_factors, stance_signs
from breastrig_studies.bodies import body_statistics, hidden_skin, trunk_depth
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.radii_factors import Score

STANCES = ("standing", "supine")
GROUPS = {
    "a": "development",
    "b": "validation",
    "c": "test",
    "d_development": None,
    "e_validation": None,
    "f_test": None,
}
DEVELOPED, VALIDATED = {"a", "d_development"}, {"b", "e_validation"}


class EnoughError(Exception):
    """What is asked here has been seen."""


@dataclass
class Read:
    """Which patients a program has looked at."""

    names: set[str] = field(default_factory=set)

    def scene(self, case: Case) -> Any:
        self.names.add(case.patient)
        bare = SimpleNamespace(vertices=np.zeros((1, 3)))
        return SimpleNamespace(case=case, truth=None, landmarks={}, fitted=lambda *_: bare, target=bare)

    def scores(self, case: Case, *_: object) -> list[Score]:
        self.names.add(case.patient)
        return [Score("seen", "wrist", 1.0, deviation=0.001, strain=1.0, part=False)]


def enough(*_: object, **__: object) -> None:
    raise EnoughError


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A cohort divided by patient.json or by the folders' names."""
    for name, half in GROUPS.items():
        for stance in STANCES:
            place = tmp_path / "bodies" / name / stance
            place.mkdir(parents=True)
            for file, said in (("case.json", {"stance": stance}), ("landmarks.json", {}), ("truth.ply", {})):
                (place / file).write_text(json.dumps(said))
            (place / "scan.ply").touch()
        about = {"capture": "ordinary", "source": name} | ({} if half is None else {"half": half})
        (tmp_path / "bodies" / name / "patient.json").write_text(json.dumps(about))
    return tmp_path / "bodies"


def learned(folder: Path, rig: Rig, read: Read, patch: pytest.MonkeyPatch) -> None:
    def residuals(cases: list[Case], *_: object) -> dict[str, Any]:
        read.names |= {case.patient for case in cases}
        return {}

    for name in ("reference_fit", "statistics", "document_of_landmarks", "write"):
        patch.setattr(learn, name, lambda *_: None)
    patch.setattr(learn, "document", lambda *_: {})
    patch.setattr(learn, "_trials", lambda *_: ())
    patch.setattr(learn, "residuals_of", residuals)
    patch.setattr(learn, "read_scene", read.scene)
    patch.setattr(learn, "FEWEST", 2)
    learn.learn(default_rig_path(), folder)


def of_bodies(folder: Path, rig: Rig, read: Read, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(body_statistics, "read_scene", read.scene)
    patch.setattr(body_statistics, "reference_fit", lambda *_: None)
    assert not [*body_statistics.known_bodies(folder, rig, None)]


def of_landmarks(folder: Path, rig: Rig, read: Read, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(landmark_errors, "read_scene", read.scene)
    patch.setattr(landmark_errors, "fitted", lambda *_: None)
    patch.setattr(landmark_errors, "residuals_of", lambda cases, *_: [read.scene(case) for case in cases] and {})
    landmark_errors.main([folder], write=False)


def of_hidden_skin(folder: Path, rig: Rig, read: Read, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(hidden_skin, "read_scene", read.scene)
    patch.setattr(hidden_skin, "hidden_heights", lambda *_: None)
    patch.setattr(hidden_skin, "estimated", enough)
    hidden_skin.main(folder, folder)


def of_radii(folder: Path, rig: Rig, read: Read, patch: pytest.MonkeyPatch) -> None:
    estimated = set[str]()

    def factors(found: radii_factors.Known, _: object) -> None:
        estimated.update(woman.split()[-1] for woman, _, _ in found)
        raise EnoughError

    patch.setattr(radii_factors, "scores_of_scan", read.scores)
    patch.setattr(radii_factors, "factors", factors)
    patch.setattr(radii_factors, "FEW", 1)  # the development half is large enough
    try:
        radii_factors.main([str(folder)], write=True)
    finally:
        assert read.names == DEVELOPED | VALIDATED  # the others are those in whom the factors are measured
        read.names = estimated


def of_stances(folder: Path, rig: Rig, read: Read, patch: pytest.MonkeyPatch) -> None:
    estimated = set[str]()

    def signs(case: Case, *_: object) -> Iterator[tuple[str, dict[str, float]]]:
        read.names.add(case.patient)
        yield f"whole {stance_signs.ALONE}", {}

    def all_estimated(scans: list[stance_signs.ScanSigns], _: object) -> None:
        estimated.update(each.source for each in scans)
        raise EnoughError

    patch.setattr(stance_signs, "signs_of", signs)
    patch.setattr(stance_signs, "all_estimated", all_estimated)
    try:
        stance_signs.main([folder])
    finally:
        assert read.names == DEVELOPED | VALIDATED
        read.names = estimated


def of_lying(folder: Path, rig: Rig, read: Read, patch: pytest.MonkeyPatch) -> None:
    bare = SimpleNamespace(vertices=np.zeros((1, 3)), points=np.zeros((1, 3)), true=np.zeros((1, 3)))
    patch.setattr(lying_motion, "read_scene", read.scene)
    patch.setattr(lying_motion, "fitted", lambda *_: bare)
    patch.setattr(lying_motion, "places", lambda *_: bare)
    assert len([*lying_motion.pairs(rig, folder)]) == len(DEVELOPED)


Program = Callable[[Path, Rig, Read, pytest.MonkeyPatch], None]
PROGRAMS: tuple[Program, ...] = (learned, of_bodies, of_landmarks, of_hidden_skin, of_radii, of_stances, of_lying)


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.__name__)
def test_only_choosing_women_teach(program: Program, folder: Path, rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    read = Read()
    with suppress(EnoughError):
        program(folder, rig, read, monkeypatch)
    assert read.names == DEVELOPED


def test_deep_trunks_are_of_both_halves_and_never_of_the_test_set(
    folder: Path, rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = Read()

    def scene(case: Case) -> Any:
        return SimpleNamespace(target=SimpleNamespace(table=None), case=read.scene(case))

    monkeypatch.setattr(trunk_depth, "read_scene", scene)
    monkeypatch.setattr(trunk_depth, "estimated", lambda *_: {})
    trunk_depth.main(folder, tmp_path)
    assert read.names == DEVELOPED | VALIDATED


def test_who_has_no_group_teaches(folder: Path) -> None:
    (folder / "c" / "patient.json").unlink()
    cases = read_cohort(folder)
    assert {case.patient for case in cases if case.teaches} == DEVELOPED | {"c"}
    assert {case.patient for case in cases if case.held_out} == {"f_test"}
