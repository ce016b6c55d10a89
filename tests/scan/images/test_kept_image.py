"""What is kept of an image: few enough bytes, in the same place, grey values in order."""

from pathlib import Path

import numpy as np
import pytest

from breastrig.core.errors import BadScan
from breastrig.scan.images import image
from breastrig.scan.images.image import ImageVolume, kept_image
from breastrig.scan.kept_image import KEPT_BYTES, read_image, write_image


def test_a_large_image_is_averaged_in_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ramp along each axis: the mm of a grey value stay where they were."""
    monkeypatch.setattr(image, "KEPT_BYTES", KEPT_BYTES // 64)
    shape = (80, 83, 41)
    i, j, k = np.meshgrid(*(np.arange(size, dtype=np.float32) for size in shape), indexing="ij")
    affine = np.array([[0.9, 0.0, 0.0, -140.0], [0.0, 0.0, 1.1, 30.0], [0.0, -0.8, 0.0, 9.0], [0.0, 0.0, 0.0, 1.0]])
    for axis in (i, j, k):
        kept = kept_image(ImageVolume(axis, affine))
        assert kept.values.nbytes <= KEPT_BYTES // 64
        low, high = np.percentile(axis, (0.5, 99.8))
        at = np.linalg.inv(affine) @ kept.affine  # kept indices to the file's
        middle = np.array(kept.values.shape) // 2
        expected = {id(i): 0, id(j): 1, id(k): 2}[id(axis)]
        value = low + kept.values[tuple(middle)] / 255.0 * (high - low)
        assert value == pytest.approx((at @ [*middle, 1.0])[expected], abs=(high - low) / 255.0)


def test_it_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    values = np.random.default_rng(3).integers(0, 4000, (12, 9, 5)).astype(np.int16)
    kept = kept_image(ImageVolume(values, np.diag([1.0, 1.0, 2.0, 1.0]), "ab12"))
    write_image(kept, tmp_path / "volume.npz")
    again = read_image(tmp_path / "volume.npz")
    assert np.array_equal(again.values, kept.values)
    assert np.array_equal(again.affine, kept.affine)
    assert again.frame == "ab12"
    (tmp_path / "volume.npz").write_bytes(b"PK\x03\x04")
    with pytest.raises(BadScan, match="stored image is damaged"):
        read_image(tmp_path / "volume.npz")
