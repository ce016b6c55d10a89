"""A process that serves one scan cleans and indexes it once, and gives the very results of one that does not."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.example_patient import EXAMPLE

from breastrig.core.assets import asset_folder
from breastrig.core.stances import AUTO
from breastrig.fitting import prepare_scan as kept_scan
from breastrig.fitting.prepare_scan import keeping, prepared_scan
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan
from breastrig.use.fit import run_fit
from breastrig.use.landmarks import ProposeJob, propose_on_file
from breastrig.use.read_upload import UploadJob, read_upload
from breastrig.use.steps.settings import FitJob

pytestmark = pytest.mark.long


@pytest.fixture(autouse=True)
def nothing_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept_scan, "_kept", kept_scan._Kept())


@pytest.fixture(scope="module")
def scan() -> Scan:
    return read_scan(EXAMPLE / "scan.ply", "ply", "auto")


def plain_call(function: Any, *given: Any) -> Any:
    return function(*given)


def test_a_scan_read_again_is_the_same_target_with_its_indices(scan: Scan) -> None:
    first = keeping(prepared_scan, scan, AUTO)
    again = replace(scan, vertices=scan.vertices.copy(), faces=scan.faces.astype(np.int32))
    assert prepared_scan(again, AUTO, first.frame).target is first.target


def test_a_vertex_elsewhere_makes_another_scan(scan: Scan) -> None:
    first = keeping(prepared_scan, scan, AUTO)
    vertices = scan.vertices.copy()
    vertices[0, 0] = np.nextafter(vertices[0, 0], np.inf)
    other = prepared_scan(replace(scan, vertices=vertices), AUTO, first.frame)
    assert other.target is not first.target
    assert not np.array_equal(other.target.vertices, first.target.vertices)


def test_another_triangle_makes_another_scan(scan: Scan) -> None:
    first = keeping(prepared_scan, scan, AUTO)
    other = prepared_scan(replace(scan, faces=scan.faces[1:]), AUTO, first.frame)
    assert len(other.target.faces) == len(first.target.faces) - 1


@pytest.mark.slow
def test_with_and_without_the_table_are_two_targets() -> None:
    lying = read_scan(asset_folder("example") / "supine" / "scan.ply", "ply", "auto")
    without = keeping(prepared_scan, lying, AUTO)
    stands = prepared_scan(lying, "standing")  # then the plane is a wall
    assert without.table_triangles > 0
    assert stands.table_triangles == 0
    assert without.target.table is not None
    assert stands.target.table is None
    assert stands.target is not without.target


def test_nothing_is_kept_where_nobody_asked_for_it(scan: Scan) -> None:
    first, second = prepared_scan(scan, AUTO), prepared_scan(scan, AUTO)
    assert first.target is not second.target
    assert kept_scan._kept == kept_scan._Kept()


@pytest.mark.slow
def test_upload_proposals_and_fits_give_the_same_bytes(tmp_path: Path) -> None:
    source = asset_folder("example") / "supine" / "scan.ply"  # with a table, which is cut away first
    found = []
    for name, call in (("cold", plain_call), ("kept", keeping)):
        folder = tmp_path / name
        folder.mkdir()
        stored = folder / "scan.stored"
        written = [folder / each for each in ("mesh.glb", "small.png", "volume.npz")]
        asked = UploadJob(source, "auto", stored, *written, 10**6)
        facts = call(read_upload, asked)
        proposed = call(propose_on_file, ProposeJob(stored, "stored", facts["unit"], None, facts["orientation"]))
        points = {mark: each["point"] for mark, each in proposed.items()}
        out = folder / "fit"
        out.mkdir()
        job = FitJob(stored, out, points, units=facts["unit"], file_type="stored", orientation=facts["orientation"])
        events = [without_times(each.model_dump(mode="json")) for each in call(lambda job: list(run_fit(job)), job)]
        files = [folder / "mesh.glb", folder / "small.png", out / "fitted.ply", out / "distances.bin"]
        found.append((json.dumps([facts, proposed, events]), [file.read_bytes() for file in files]))
    assert found[0] == found[1]


def without_times(value: Any) -> Any:
    """The same document without what a clock said."""
    if isinstance(value, dict):
        return {key: without_times(each) for key, each in value.items() if key not in ("timing_s", "elapsed_s")}
    return [without_times(each) for each in value] if isinstance(value, list) else value
