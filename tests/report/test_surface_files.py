"""Surfaces for other programs: the same bytes as those of trimesh near the origin, all digits far from it."""

import io

import numpy as np
import pytest
import trimesh
from helpers.toy_rig import toy_rig

from breastrig.report.files.geometry_files import surface_ply, surface_stl

FAR = np.array([10_000.123456789, -4_321.987654321, 8_765.4321])  # m
PER_UNIT = {"m": 1.0, "mm": 1e-3}


@pytest.mark.parametrize("unit", PER_UNIT)
@pytest.mark.parametrize("place", [np.zeros(3), FAR], ids=["near", "far"])
@pytest.mark.parametrize("kind", ["ply", "stl"])
def test_a_surface_is_exact_to_a_hundredth_of_a_millimetre(kind: str, place: np.ndarray, unit: str) -> None:
    rig = toy_rig()
    write = {"ply": surface_ply, "stl": surface_stl}[kind]
    data = write(rig.template + place, rig.faces, PER_UNIT[unit])
    read = trimesh.load(io.BytesIO(data), file_type=kind, process=False)
    assert len(read.faces) == len(rig.faces)
    found = PER_UNIT[unit] * np.asarray(read.vertices[read.faces])
    np.testing.assert_allclose(found, (rig.template + place)[rig.faces], rtol=0, atol=1e-5)


def test_near_the_origin_files_are_binary_and_in_single_precision() -> None:
    rig = toy_rig()
    mesh = trimesh.Trimesh(rig.template, rig.faces, process=False)
    library = mesh.export(file_type="ply", include_attributes=False)
    assert surface_ply(rig.template, rig.faces, 1.0) == library.replace(
        b"comment https://github.com/mikedh/trimesh\n", b""
    )
    assert surface_stl(rig.template, rig.faces, 1.0) == mesh.export(file_type="stl")
