"""The patient that comes with the package."""

from pathlib import Path
from typing import Literal, NamedTuple

from breastrig.core.assets import asset_folder


class Example(NamedTuple):
    """The files of one scan, in the order in which `fit` takes them: `breastrig.fit(*breastrig.example())`."""

    scan: Path
    landmarks: Path


def example(stance: Literal["standing", "supine"] = "standing") -> Example:
    """The scan of the packaged patient (computed, not a person) in a stance, with its landmarks.

    The scan says its unit and frame, the landmark file its own.  Raises nothing; errors are `fit`'s.
    """
    folder = asset_folder("example") / stance
    return Example(folder / "scan.ply", folder / "landmarks.json")
