"""A fit's folder read back, and one sentence for each way in which it cannot be."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.results import without_hashes

from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadInput
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.modes import with_modes
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from breastrig.use.fit import run_fit
from breastrig.use.folder.fit_folder import read_fit_folder
from breastrig.use.steps.events import Done
from breastrig.use.steps.settings import FitJob
from breastrig_studies.output.rig_files import write_rig

EXAMPLE = asset_folder("example") / "standing"


def picks() -> dict[str, list[float]]:
    return {name: list(place) for name, place in read_landmarks(EXAMPLE / "landmarks.json")[0].items()}


def fitted(out: Path, landmarks: dict[str, list[float]]) -> Path:
    *_, last = run_fit(FitJob(scan=EXAMPLE / "scan.ply", out=out, landmarks_mm=landmarks, refine=False))
    assert isinstance(last, Done)
    return out


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fitted(tmp_path_factory.mktemp("fit"), picks())


def test_what_was_fitted_comes_back(folder: Path) -> None:
    found = read_fit_folder(folder)
    surface = clean(read_scan(EXAMPLE / "scan.ply"))
    np.testing.assert_allclose(found.surface.vertices, surface.vertices, atol=1e-6)
    np.testing.assert_array_equal(found.surface.faces, surface.faces)
    modes = with_modes(found.rig).blendshapes[len(found.rig.shapes) :]
    still = np.abs(modes).max(axis=(0, 2)) < 1e-8
    assert 200 < still.sum() < len(still)
    alone = pose(found.rig, found.parameters)
    np.testing.assert_allclose(found.vertices[still], alone[still], atol=1e-6)
    assert 1e-3 < np.abs(found.vertices - alone).max() < 0.01  # the breasts' modes
    for name, place in picks().items():
        np.testing.assert_allclose(found.landmarks[name], 1e-3 * np.array(place), atol=2e-6)
    assert (found.stance, found.metres_per_unit, found.unit) == ("standing", 1.0, "m")
    assert found.rig.sha256 == read_rig(default_rig_path()).sha256


def test_landmarks_seen_by_colour_are_read_where_they_are_and_must_be_the_models(folder: Path, tmp_path: Path) -> None:
    assert read_fit_folder(folder).seen == {}  # picked ones are not, and older results say nothing of it
    place = without_hashes(shutil.copytree(folder, tmp_path / "fit")) / "result.json"
    document = json.loads(place.read_text("utf-8"))
    place.write_text(json.dumps(document | {"landmarks_seen": {"umbilicus": "navel seen"}}), "utf-8")
    assert read_fit_folder(place.parent).seen["umbilicus"].tolist() == document["landmarks"]["umbilicus"]
    place.write_text(json.dumps(document | {"landmarks_seen": {"tail": "seen"}}), "utf-8")
    with pytest.raises(BadInput, match=r"\(landmarks_seen\)"):
        read_fit_folder(place.parent)


def test_the_scan_that_is_kept_says_nothing_but_its_shape(folder: Path) -> None:
    header = (folder / "scan.ply").read_bytes().split(b"end_header")[0]
    for line in header.splitlines():
        assert line.split()[0] in {b"ply", b"format", b"element", b"property"} or line.endswith(b"trimesh")


def _edit(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def edit(folder: Path) -> None:
        document = json.loads((folder / "result.json").read_text())
        change(document)
        (folder / "result.json").write_text(json.dumps(document))

    return edit


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda folder: (folder / "result.json").unlink(), "There is no fit in"),
        (lambda folder: (folder / "result.json").write_text('{"schema": '), "is damaged or of another version"),
        (lambda folder: (folder / "scan.ply").unlink(), "is missing"),
        (lambda folder: (folder / "scan.ply").write_bytes(b"ply\n"), "is damaged"),
        (lambda folder: shutil.copy(folder / "scan.ply", folder / "fitted.ply"), "is not the fitted model"),
        (_edit(lambda result: result["parameters"]["bones"].pop()), "other bones or shapes"),
        (_edit(lambda result: result.pop("landmarks_picked")), "landmarks_picked"),
        (_edit(lambda result: result["landmarks_picked"].update(elbow=[0.0, 0.0, 0.0])), "landmarks_picked"),
        (_edit(lambda result: result["parameters"]["bones"][0].update(rotation_xyzw=[0.0] * 4)), "rotation"),
    ],
)
def test_a_damaged_folder_is_one_sentence(
    damage: Callable[[Path], object], sentence: str, folder: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "fit"
    without_hashes(shutil.copytree(folder, copy))
    damage(copy)
    with pytest.raises(BadInput, match=sentence) as error:
        read_fit_folder(copy)
    assert "\n" not in str(error.value)
    assert str(error.value).endswith(".")


def test_a_fit_of_another_model_says_so(folder: Path, toy_rig: Rig, tmp_path: Path) -> None:
    write_rig(toy_rig, tmp_path)
    with pytest.raises(BadInput, match="fitted with another model"):
        read_fit_folder(folder, tmp_path / "toy.glb")
