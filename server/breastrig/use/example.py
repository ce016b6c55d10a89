"""The patient that comes with the package."""

from pathlib import Path
from typing import Literal, NamedTuple

from breastrig.core.assets import asset_folder


class Example(NamedTuple):
    """The files of one scan, in the order in which `fit` takes them: `breastrig.fit(*breastrig.example())`."""

    scan: Path
    landmarks: Path


SCANS = {"standing": "scan.ply", "supine": "scan.ply", "marked": "scan.zip", "mri": "scan.nii.gz"}


def example(name: Literal["standing", "supine", "marked", "mri"] = "standing") -> Example:
    """A scan of the packaged patient (computed, not a person), with its landmarks.

    `marked` is standing with lines of a pen on the skin, in a picture; `mri` is a prone label map with two lesions,
    which is read with the extra `mri`.  A scan says its unit and frame, the landmark file its own.  Raises nothing;
    errors are `fit`'s.
    """
    folder = asset_folder("example") / name
    return Example(folder / SCANS[name], folder / "landmarks.json")
