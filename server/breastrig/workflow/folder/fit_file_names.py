"""The names of the files that a fit leaves, for all who need to know no more of them."""

from pathlib import Path

from breastrig.core.output_files import OutputSet

RESULT = "result.json"
UNCERTAINTY = "uncertainty.bin"
RESULT_SCHEMA = "breastrig/result@1"
LANDMARKS_SEEN = "landmarks_seen"  # in it
DRAWING_MISSING = "drawing_missing"  # in it; left out where nothing is
FIT_FILES = (
    "scan.ply",
    "fitted.ply",
    "fitted.glb",
    "drawing.json",
    "distances.bin",
    UNCERTAINTY,
    "fit.log.jsonl",
    RESULT,  # the last one: where it stands, the others are there
)


def fit_set(folder: Path) -> OutputSet:
    """The files of a fit, in a folder of an output's."""
    return OutputSet(folder, FIT_FILES, RESULT, RESULT_SCHEMA)
