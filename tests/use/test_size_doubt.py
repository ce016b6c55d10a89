"""An upload whose size is no ordinary torso's: asked about by the body alone, without what stands around it."""

from pathlib import Path

import numpy as np
import pytest
from helpers.scan_files import ply_text

from breastrig.core.assets import asset_folder
from breastrig.scan.read import read_scan
from breastrig.use.read_upload import UploadJob, read_upload

EXAMPLE = asset_folder("example") / "standing" / "scan.ply"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wall_m", "unit", "said"),
    [(2.0, "ft", "less than scans usually show; check unit and export. In metres")],
)
def test_a_wall_makes_no_size_doubtful_but_the_unit_that_was_read_from_it(
    wall_m: float, unit: str, said: str, tmp_path: Path
) -> None:
    scan = read_scan(EXAMPLE)
    steps = int(60 * wall_m)
    across, up = np.meshgrid(*[np.linspace(-wall_m / 2, wall_m / 2, steps)] * 2)
    middle, behind = scan.vertices.mean(axis=0), scan.vertices[:, 2].min() - 0.1
    wall = np.column_stack([across.ravel() + middle[0], up.ravel() + middle[1], np.full(steps**2, behind)])
    first = np.add.outer(steps * np.arange(steps - 1), np.arange(steps - 1)).reshape(-1, 1)
    faces = np.vstack([np.add(first, corners) for corners in ([0, 1, steps], [1, steps + 1, steps])])
    file = tmp_path / "scan.ply"
    file.write_bytes(ply_text(np.vstack([scan.vertices, wall]), np.vstack([scan.faces, len(scan.vertices) + faces])))
    places = {name: tmp_path / name for name in ("mesh", "thumbnail", "kept", "volume")}
    facts = read_upload(UploadJob(scan=file, units="auto", triangles=10**6, model=None, **places))
    assert facts["unit"] == unit
    assert said in facts["size_doubt"]
    assert bool(facts["size_doubt"]) == bool(said)
