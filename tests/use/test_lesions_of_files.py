"""An image with the lesions of another file: read, fitted, and in a case."""

from pathlib import Path

import numpy as np
import pytest
from helpers.example_image import LANDMARKS, LESIONS, example_image

import breastrig
from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadScan

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
