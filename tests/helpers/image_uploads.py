"""Uploads that are read as if they had been made of an image: a worker imports this by name."""

from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from breastrig.scan.kept_image import KeptImage
from breastrig.scan.scan import Scan
from breastrig.use import read_upload as reader

SHAPE = (7, 5, 9)
AFFINE = np.array([[40.0, 0.0, 0.0, -120.0], [0.0, 0.0, 20.0, -160.0], [0.0, -40.0, 0.0, 230.0], [0.0, 0.0, 0.0, 1.0]])
# Light behind, so that the lesion of `label_maps` lies in tissue.
IMAGE = KeptImage(np.tensordot([1, 5, 25], np.indices(SHAPE), 1).astype(np.uint8), AFFINE, "ab12")
READ = reader.read_scan


def with_image(source: Path | bytes, *given: Any, **named: Any) -> Scan:
    """As `read_scan`."""
    return replace(READ(source, *given, **named), image=IMAGE)


def read_upload_of_image(job: reader.UploadJob) -> dict[str, Any]:
    """As `read_upload`."""
    with patch.object(reader, "read_scan", with_image):
        return reader.read_upload(job)
