"""What other programs make of the same DICOM files: a scanner's own header and packings, and the places of slices."""

import io
import warnings
from dataclasses import replace

import highdicom
import numpy as np
import pydicom
import pytest
from helpers.chest_image import chest_image
from helpers.dicom_files import Series, file_dataset, files, slices, uid, zipped
from pydicom.data import get_testdata_file

from breastrig.scan.images.dicom_images import DicomImage, image_in
from breastrig.scan.volumes.answers import NOTHING_SAID

PACKINGS = ("", "_bigendian", "_implicit", "_padded", "_expb", "_RLE", "_jp2klossless", "_jpeg_ls_lossless")
COUNT, STEP = 10, 2.5  # slices, mm


@pytest.mark.parametrize("packing", PACKINGS)
def test_a_scanners_own_header_and_packings(packing: str) -> None:
    """pydicom's picture of a real MR scanner, repeated along its normal."""
    file = get_testdata_file(f"MR_small{packing}.dcm")
    assert isinstance(file, str)
    made = pydicom.dcmread(file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of bytes behind the pixels
        expected = made.pixel_array.copy()
    place, turn = np.array(made.ImagePositionPatient, float), np.array(made.ImageOrientationPatient, float)
    normal = np.cross(turn[:3], turn[3:])
    content = {}
    for at in range(COUNT):
        made.ImagePositionPatient = [float(each) for each in np.round(place + at * STEP * normal, 6)]
        made.SOPInstanceUID = made.file_meta.MediaStorageSOPInstanceUID = uid(packing, at)
        stream = io.BytesIO()
        made.save_as(stream)
        content[str(at)] = stream.getvalue()
    found = image_in(zipped(content), NOTHING_SAID)
    assert isinstance(found, DicomImage)
    np.testing.assert_array_equal(found.image.values, np.repeat(expected.T[:, :, None], COUNT, axis=2))
    affine = np.eye(4)
    affine[:3, :3] = np.column_stack([turn[:3] * made.PixelSpacing[1], turn[3:] * made.PixelSpacing[0], STEP * normal])
    affine[:3, 3] = place
    np.testing.assert_allclose(found.image.affine, affine, atol=1e-3)


def test_places_are_those_of_another_reader() -> None:
    turn = np.eye(4)
    turn[:3, :3] = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn[:3, :3] *= np.linalg.det(turn[:3, :3])
    series = Series(replace(chest_image(), affine=turn @ chest_image().affine))
    other = highdicom.get_volume_from_series([file_dataset(each, series) for each in slices(series)])
    ours = image_in(zipped(files(series)), NOTHING_SAID)
    assert isinstance(ours, DicomImage)
    corner = ours.image.affine @ [93, 59, 39, 1]  # column, row, slice
    there = other.affine @ [39, 59, 93, 1]  # slice, row, column
    back = other.affine @ [0, 59, 93, 1]  # it may begin with the last slice
    assert min(np.linalg.norm(corner - there), np.linalg.norm(corner - back)) < 1e-3
