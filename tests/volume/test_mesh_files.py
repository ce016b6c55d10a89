"""The inside of a fit as files: other programs read what was meant; what is not to be had is one sentence."""

import importlib.util
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import meshio
import numpy as np
import pytest

import breastrig
from breastrig.cli.main import main
from breastrig.core.arrays import Array
from breastrig.volume.volume_mesh import REGIONS


@pytest.fixture(scope="module")
def volume(fits: Path) -> breastrig.Volume:
    return breastrig.volume_mesh(fits / "standing")


@pytest.fixture(scope="module")
def saved(volume: breastrig.Volume, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("volumes")
    for ending in ("vtu", "msh", "scn", "feb"):
        volume.save(folder / f"torso.{ending}")
    return folder


def numbers(text: str | None, columns: int) -> Array:
    return np.array((text or "").replace(",", " ").split(), dtype=float).reshape(-1, columns)


def test_arrays_are_in_the_scans_unit_and_frame(volume: breastrig.Volume, fits: Path) -> None:
    fit = breastrig.Fit.load(fits / "standing")
    assert volume.unit == fit.unit
    gaps = np.linalg.norm(volume.points[: len(fit.vertices)] - fit.vertices, axis=1) * fit.metres_per_unit
    assert gaps.max() == pytest.approx(volume.in_metres.moved, abs=1e-9)
    assert {"fixed", "sliding", "cuts"} < volume.sets.keys()


def test_scikit_fem_keeps_all_groups_of_an_msh_as_the_page_says(
    volume: breastrig.Volume, saved: Path, repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (repository / "docs/how-to/finite_elements.md").read_text("utf-8")
    code = page.split("```python\nimport skfem")[1].split("```")[0]
    monkeypatch.chdir(saved)
    known: dict[str, Any] = {}
    exec("import skfem" + code, known)
    nodes, names, cells, numbers = (known[name] for name in ("nodes", "names", "cells", "numbers"))
    assert {name: each.tolist() for name, each in nodes.items()} == {
        name: each.tolist() for name, each in volume.sets.items()
    }
    assert known["held"].size == len(volume.sets["fixed"])
    for name, triangles in (("skin_surface", volume.surface), ("wall_surface", volume.in_metres.wall)):
        kept = cells["triangle"][numbers["triangle"] == names[name][0]]
        np.testing.assert_array_equal(kept, triangles)
    assert {name for name, (_, dimension) in names.items() if dimension == 3} == set(REGIONS)


def test_vtk_and_gmsh_have_sets_and_model_vertices(volume: breastrig.Volume, saved: Path) -> None:
    vtu, msh = meshio.read(saved / "torso.vtu"), meshio.read(saved / "torso.msh")
    np.testing.assert_array_equal(vtu.point_data["model_vertex"], volume.model_vertex)
    for name, members in volume.sets.items():
        np.testing.assert_array_equal(np.flatnonzero(vtu.point_data[name]), members)
        number = msh.field_data[name][0]
        held = msh.cells_dict["vertex"][msh.cell_data_dict["gmsh:physical"]["vertex"] == number]
        np.testing.assert_array_equal(held.ravel(), members)


def test_the_sofa_scene_reads_back(volume: breastrig.Volume, saved: Path) -> None:
    root = Xml.parse(saved / "torso.scn").getroot()
    body = root.find("Node[@name='torso']")
    containers = {each.get("name"): each for each in body.findall("TetrahedronSetTopologyContainer")}
    mesh = volume.in_metres
    np.testing.assert_allclose(numbers(containers["mesh"].get("position"), 3), mesh.points, atol=1e-8)
    np.testing.assert_array_equal(numbers(containers["mesh"].get("tetrahedra"), 4), mesh.tetrahedra)
    for index, name in enumerate(REGIONS):
        of_region = numbers(containers[name].get("tetrahedra"), 4)
        np.testing.assert_array_equal(of_region, mesh.tetrahedra[mesh.region == index])
    sets = {each.get("name"): numbers(each.get("indices"), 1) for each in body.iter("FixedProjectiveConstraint")}
    assert sets.keys() == volume.sets.keys()
    assert all(np.array_equal(members.ravel(), volume.sets[name]) for name, members in sets.items())
    [active] = body.findall("FixedProjectiveConstraint")
    assert active.get("name") == "fixed"
    assert np.linalg.norm(numbers(root.get("gravity"), 3)) == pytest.approx(9.81)


def test_the_febio_model_reads_back(volume: breastrig.Volume, saved: Path) -> None:
    root, mesh = Xml.parse(saved / "torso.feb").getroot(), volume.in_metres
    points = numbers(" ".join(node.text or "" for node in root.iterfind("Mesh/Nodes/node")), 3)
    np.testing.assert_allclose(points, mesh.points, atol=1e-8)
    read = np.zeros_like(mesh.tetrahedra)
    for elements in root.iterfind("Mesh/Elements"):
        rows = np.array([int(each.get("id", 0)) - 1 for each in elements])
        read[rows] = numbers(" ".join(each.text or "" for each in elements), 4) - 1
        assert {REGIONS[region] for region in mesh.region[rows]} == {elements.get("name")}
    np.testing.assert_array_equal(read, mesh.tetrahedra)
    for nodes in root.iterfind("Mesh/NodeSet"):
        np.testing.assert_array_equal(numbers(nodes.text, 1).ravel() - 1, volume.sets[nodes.get("name", "")])
    materials = {each.get("name") for each in root.iterfind("Material/material")}
    assert {each.get("mat") for each in root.iterfind("MeshDomains/SolidDomain")} == materials == set(REGIONS)


def test_weight_pulls_towards_the_feet_of_a_standing_body(fits: Path, saved: Path) -> None:
    scene, model = (Xml.parse(saved / f"torso.{ending}").getroot() for ending in ("scn", "feb"))
    gravity = numbers(scene.get("gravity"), 3)[0]
    fit = breastrig.Fit.load(fits / "standing")
    down = fit.landmarks["umbilicus"] - fit.landmarks["suprasternal_notch"]
    assert gravity @ down > 0.9 * 9.81 * np.linalg.norm(down)
    np.testing.assert_allclose(numbers(model.findtext("Loads/body_load/force"), 3)[0], -gravity)  # FEBio subtracts it


def test_the_command_writes_the_same_and_says_what(
    fits: Path, saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["volume", str(fits / "standing"), "-o", str(tmp_path / "torso.feb")]) == 0
    assert (tmp_path / "torso.feb").read_bytes() == (saved / "torso.feb").read_bytes()
    said = capsys.readouterr().out
    assert "breast_L 0." in said
    (row,) = (each for each in breastrig.measure(fits / "standing") if each.name == "volume")
    assert f"; {row.left.value:.0f} and {row.right.value:.0f} ml in a report, down to where the skin would be" in said


def test_other_endings_and_a_missing_extra_are_sentences(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["volume", str(fits / "standing"), "-o", str(tmp_path / "torso.stl")]) == 2
    assert capsys.readouterr().err.startswith("breastrig: A volume is written as .vtu, .msh, .scn (SOFA) or .feb")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert main(["volume", str(fits / "standing"), "-o", str(tmp_path / "torso.vtu")]) == 2
    assert 'need "breastrig[volume]"' in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_unsound_tetrahedra_are_said(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("breastrig.volume.tetrahedra.untangle", lambda points, *_: -points)
    assert main(["volume", str(fits / "standing"), "-o", str(tmp_path / "torso.feb")]) == 3
    assert re.search(r"(\d+) tetrahedra .* \(\1 are inverted\), for the fitted skin is folded", capsys.readouterr().err)
