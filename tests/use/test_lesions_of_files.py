"""An image with the lesions of another file: read, fitted, and in a case."""

from pathlib import Path

import numpy as np
import pytest
from helpers.example_image import LANDMARKS, LESIONS, example_image

import breastrig
from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadScan, NotFound

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("image") / "mri.zip"
    file.write_bytes(example_image())
    return file


def test_a_fit_of_an_image_has_the_lesions_of_the_other_file(image: Path) -> None:
    wanted = breastrig.read_scan(LESIONS).in_metres.lesions
    assert len(wanted) == 2
    fit = breastrig.fit(image, LANDMARKS, lesions=[LESIONS])
    found = fit.in_metres.result.lesions
    assert [each.name for each in found] == ["Lesion 1", "Lesion 2"]
    for each, lesion in zip(found, wanted, strict=True):
        assert np.allclose(each.center, 1e3 * lesion.center, atol=1e-3)  # mm, the scan's unit
        assert each.radius_mm == pytest.approx(1e3 * lesion.radius, abs=1e-3)
    assert [each.name for each in fit.lesions] == ["Lesion 1", "Lesion 2"]
    assert LESIONS in fit.inputs


def test_a_scan_of_no_image_takes_none() -> None:
    with pytest.raises(BadScan, match="made of no image"):
        breastrig.fit(asset_folder("example") / "standing" / "scan.ply", lesions=[LESIONS])
    with pytest.raises(BadScan, match="no scan file"):
        breastrig.read_scan(LESIONS).with_lesions("nothing.nii")


def test_a_case_has_them_in_its_plan(image: Path, tmp_path: Path) -> None:
    case = breastrig.Case.create(tmp_path / "hers")
    scan = case.add_scan(image)
    assert (case.scans[0].folder / "volume.npz").is_file()
    first = case.add_lesions(scan, LESIONS)
    assert [(each.name, each.is_new) for each in first.lesions] == [("Lesion 1", True), ("Lesion 2", True)]
    assert first.notes
    again = case.add_lesions(scan, LESIONS)
    assert [each.is_new for each in again.lesions] == [False, False]
    items = case.plan()["items"]
    assert [(each["kind"], each["name"], each["scan"]) for each in items] == [
        ("lesion", "Lesion 1", scan), ("lesion", "Lesion 2", scan),
    ]  # fmt: skip
    assert items[0]["center"] == pytest.approx(first.lesions[0].center.tolist())
    surface = case.add_scan(asset_folder("example") / "standing" / "scan.ply")
    with pytest.raises(BadScan, match="made of no image"):
        case.add_lesions(surface, LESIONS)
    with pytest.raises(NotFound):
        case.add_lesions("A" * 22, LESIONS)
    case.delete_scan(scan)
    assert case.plan()["items"] == []
    assert list(tmp_path.rglob("volume.npz")) == []
