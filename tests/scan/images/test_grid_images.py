"""An image in one file (NIfTI, NRRD, MetaImage) is the scan that its DICOM series is."""

import gzip

import numpy as np
import pytest
from helpers.grid_files import meta_fields, meta_image, nrrd, nrrd_fields
from helpers.label_maps import placed_nifti
from helpers.mr_image import MrImage, mr_image

from breastrig.core.errors import BadScan, BadSettings, NeedsAnswer
from breastrig.scan.images.grid_image import image_of
from breastrig.scan.images.image import kept_image
from breastrig.scan.images.image_pieces import image_pieces
from breastrig.scan.read import read_scan
from breastrig.scan.volumes.answers import checked_answers
from breastrig.scan.volumes.grids.grid import Grid
from breastrig.scan.volumes.volume_files import read_volume

RAS = np.diag([-1.0, -1.0, 1.0, 1.0])


@pytest.fixture(scope="module")
def true() -> MrImage:
    return mr_image("plain", step=5.0)


def grey(true: MrImage) -> np.ndarray:
    return np.asfortranarray(true.image.values).astype("<i2")


def test_every_format_holds_the_same_image(true: MrImage) -> None:
    values, affine = grey(true), true.image.affine
    skin = image_pieces(true.image).pieces[0]
    for data in (
        gzip.compress(placed_nifti(values, (RAS @ affine, 1), (RAS @ affine, 1))),
        nrrd(values, nrrd_fields(values, affine)),
        meta_image(values.astype("<f4"), meta_fields(values.astype("<f4"), affine)),
    ):
        scan = read_scan(data)
        assert (scan.from_image, scan.from_label_map, scan.unit, scan.lesions) == (True, False, "mm", ())
        assert scan.image is not None
        assert scan.image.affine == pytest.approx(affine, abs=1e-4)
        assert np.abs(scan.image.values.astype(int) - kept_image(true.image).values).max() <= 1
        assert 1e3 * scan.vertices == pytest.approx(skin.vertices, abs=0.02)
        with pytest.raises(BadSettings, match="an image, which has no segments"):
            read_scan(data, answers=checked_answers(None, {1: "lesion"}))
        with pytest.raises(BadSettings, match="no DICOM image; series is for those alone"):
            read_scan(data, answers=checked_answers(None, series="ab12"))


def test_an_image_that_does_not_say_which_side_is_left_is_asked_with_pictures(true: MrImage) -> None:
    values = grey(true)
    steps = np.full(3, 5.0)
    affine = np.diag([*steps, 1.0])
    fields = nrrd_fields(values, affine)
    del fields["space"]
    for data in (placed_nifti(values, (affine, 0), (affine, 0)), nrrd(values, fields)):
        with pytest.raises(NeedsAnswer, match="does not say which side is left") as caught:
            read_scan(data)
        choices = {each["value"]: each for each in caught.value.question["choices"]}
        assert {"LPS", "RPS", "LPI", "RPI"} <= set(choices)
        assert not {"LAS", "RAS", "LAI", "RAI"} & set(choices)  # the front has air, so that is known
        assert all(each["picture"].startswith("data:image/png;base64,") for each in choices.values())
        scan = read_scan(data, answers=checked_answers("LPS"))
        assert scan.image is not None
        middle = scan.image.affine @ [*(0.5 * (np.array(values.shape) - 1)), 1.0]
        assert middle[:3] == pytest.approx(np.zeros(3), abs=1e-6)
        assert any("was said by a person" in note for note in scan.notes)


def test_scaled_values_are_those_meant_and_what_is_no_number_is_dark(true: MrImage) -> None:
    values = true.image.values.astype(np.float32)
    values[0, 0, 0], values[1, 0, 0] = np.nan, np.inf
    found = read_volume(nrrd(values, nrrd_fields(values, true.image.affine)), "nrrd", None)
    assert isinstance(found, Grid)
    image = image_of(found)
    assert np.isfinite(image.values).all()
    assert image.values[0, 0, 0] == image.values[1, 0, 0] == image.values.min()
    scaled = Grid((grey(true),), found.frames, slope=-2.0, intercept=7.0)
    assert np.asarray(image_of(scaled).values) == pytest.approx(7.0 - 2.0 * grey(true))


def test_an_image_of_nothing_is_one_sentence() -> None:
    for value in (np.nan, 0.5):
        nothing = np.full((20, 20, 20), value, np.float32)
        nothing[0] = np.nan
        with pytest.raises(BadScan, match=r"all its values are the same|shows no skin"):
            read_scan(nrrd(nothing))
