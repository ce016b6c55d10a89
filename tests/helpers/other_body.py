"""A fit that says of itself that its body is another one: each of its bones is larger."""

from pathlib import Path

import numpy as np

from breastrig.files.result import BODY, FIT_FILES, RESULT, read_result
from breastrig.gltf.read_rig import default_rig_path, read_rig

BONES = len(read_rig(default_rig_path()).bones)


def with_other_body(folder: Path, larger: float = 1.2) -> None:
    """Changes body.bin, and result.json, which has its hash."""
    numbers = np.frombuffer((folder / BODY).read_bytes(), "<f4").copy()
    numbers[: 3 * BONES] *= larger
    (folder / BODY).write_bytes(numbers.tobytes())
    files = {name: (folder / name).read_bytes() for name in FIT_FILES if (folder / name).is_file()}
    (folder / RESULT).write_bytes(read_result(folder).beside(files).content())
