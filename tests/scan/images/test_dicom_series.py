"""MR images as DICOM: slices lie where their headers say, whatever the files are called and however they are packed."""

from functools import cache
from pathlib import Path

import numpy as np
from helpers.dicom_files import Series, enhanced, file_of, files, foldered, zipped

from breastrig.fitting.prepare_scan import prepared_scan
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.read import read_scan
from breastrig.scan.stored_scan import STORED, write_stored


@cache
def image() -> ImageVolume:
    """A chest with two half balls, 3 mm voxels, axial."""
    sizes, low, shape = np.array([3.0, 3.0, 4.0]), np.array([-140.0, -90.0, 60.0]), (94, 60, 40)
    at = np.stack(np.meshgrid(*[low[k] + sizes[k] * np.arange(shape[k]) for k in range(3)], indexing="ij"), axis=-1)
    body = at[..., 1] > 0.0
    for centre in ([65.0, -5.0, 140.0], [-65.0, -5.0, 140.0]):
        body |= np.linalg.norm(at - centre, axis=-1) < 60.0
    rng = np.random.default_rng(1)
    values = np.hypot(600.0 * body + rng.normal(0, 8, shape), rng.normal(0, 8, shape)).astype(np.uint16)
    affine = np.diag([*sizes, 1.0])
    affine[:3, 3] = low
    return ImageVolume(values, affine, "")


def test_every_door_gives_the_same_scan(tmp_path: Path) -> None:
    content = files(Series(image()))
    folder = foldered(content, tmp_path / "mri")
    archive = tmp_path / "a.zip"
    archive.write_bytes(zipped(content))
    scans = [
        read_scan(folder),
        read_scan(archive),
        read_scan(archive.read_bytes()),
        read_scan(file_of(enhanced(Series(image())))),
    ]
    for scan in scans:
        assert (scan.unit, scan.from_image, scan.from_label_map, scan.in_patient_frame) == ("mm", True, False, True)
        np.testing.assert_array_equal(scan.vertices, scans[0].vertices)
        assert scan.image is not None
        np.testing.assert_allclose(scan.image.affine, image().affine, atol=1e-9)
        assert scan.image.values.shape == image().values.shape
        assert prepared_scan(scan, "auto").frame.stance == "prone"
    front = scans[0].vertices[:, 1].min()
    assert abs(front + 0.065) < 0.003
    kept = tmp_path / "scan.stored"
    write_stored(scans[0], kept)
    again = read_scan(kept, STORED)
    assert again.in_patient_frame
    assert again.from_image
    assert prepared_scan(again, "auto").frame.known is not None
