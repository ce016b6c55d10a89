"""A volume mesh as files of other programs, by ending: .vtu, .msh (meshio), .scn (SOFA), .feb (FEBio).

.vtu and .msh are in the scan's unit; the two decks are in SI units, with the body's own weight in the direction of the
stance and one stiffness for all tissue: a start for an own simulation, not one.  All are in the scan's frame.
"""

import importlib.util
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.volume.volume_mesh import REGIONS, VolumeMesh

NEEDS = '{} files need "breastrig[volume]"; install it, or write .scn or .feb.'
ENDINGS = "A volume is written as .vtu, .msh, .scn (SOFA) or .feb (FEBio); give a file with one of these endings."
DENSITY = 1000.0  # kg/m³, of fat and gland within a tenth
GRAVITY = 9.81  # m/s²
YOUNG = 750.0  # Pa, three times the median shear modulus of breastrig_studies/gravity/tissue.toml (decision 0020)
POISSON = 0.48  # nearly incompressible, and still bearable for linear tetrahedra
SOFA_PLUGINS = (
    "Constraint.Projective",
    "LinearSolver.Iterative",
    "Mass",
    "ODESolver.Backward",
    "SolidMechanics.FEM.Elastic",
    "StateContainer",
    "Topology.Container.Dynamic",
)
SURFACES = ("skin_surface", "wall_surface")


@dataclass(frozen=True, eq=False)
class Wanted:
    """A file's content besides the mesh."""

    metres_per_unit: float  # of .vtu and .msh
    down: Array  # (3,) unit, in the scan's frame


def check_name(name: str) -> None:
    """Raises BadInput for an unsupported ending, or where its library is not installed."""
    ending = Path(name).suffix.lower()
    if ending not in WRITERS:
        raise BadInput(ENDINGS)
    if ending in (".vtu", ".msh") and importlib.util.find_spec("meshio") is None:
        raise BadInput(NEEDS.format(ending))


def mesh_file(mesh: VolumeMesh, name: str, wanted: Wanted) -> bytes:
    """The content of the file `name`; BadInput as check_name."""
    check_name(name)
    return WRITERS[Path(name).suffix.lower()](mesh, wanted)


def _vtu(mesh: VolumeMesh, wanted: Wanted) -> bytes:
    """Node sets as arrays of 0 and 1; regions as scikit-fem reads them, and as one number."""
    import meshio

    nodes = {"model_vertex": mesh.model_vertex.astype(np.int32), "depth": mesh.depth}
    nodes |= {
        name: np.isin(np.arange(len(mesh.points)), members).astype(np.uint8) for name, members in mesh.node_sets.items()
    }
    cells: dict[str, list[Any]] = {f"skfem:s:{name}": [mesh.inside(name).astype(np.uint8)] for name in REGIONS}
    cells |= {"region": [mesh.region.astype(np.uint8)], "scaled_jacobian": [mesh.scaled_jacobian]}
    made = meshio.Mesh(
        mesh.points / wanted.metres_per_unit, [("tetra", mesh.tetrahedra)], point_data=nodes, cell_data=cells
    )
    return _written("torso.vtu", lambda file: meshio.vtu.write(file, made))


def _msh(mesh: VolumeMesh, wanted: Wanted) -> bytes:
    """Version 2.2: regions, surfaces and node sets are physical groups; nodes of the skin are the model's vertices in
    their order.  No data on nodes: meshio 5.3 writes them as NumPy 2 prints them, and cannot read them back.
    """
    import meshio

    blocks: list[tuple[str, Integers]] = []
    numbers: list[Integers] = []
    names: dict[str, Array] = {}

    def add(kind: str, dimension: int, name: str, members: Integers) -> None:
        blocks.append((kind, members))
        names[name] = np.array([len(names) + 1, dimension])
        numbers.append(np.full(len(members), len(names), dtype=np.int32))

    for name in REGIONS:
        add("tetra", 3, name, mesh.tetrahedra[mesh.inside(name)])
    for name, triangles in zip(SURFACES, (mesh.surface, mesh.wall), strict=True):
        add("triangle", 2, name, triangles)
    for name, nodes in mesh.node_sets.items():
        add("vertex", 0, name, nodes[:, None])
    made = meshio.Mesh(
        mesh.points / wanted.metres_per_unit,
        blocks,
        cell_data={"gmsh:physical": numbers, "gmsh:geometrical": numbers},
        field_data=names,
    )
    return _written(
        "torso.msh", lambda file: meshio.gmsh.write(file, made, fmt_version="2.2", binary=False, float_fmt=".9g")
    )


def _written(name: str, write: Callable[[str], None]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / name
        write(str(file))
        return file.read_bytes()


def _sofa(mesh: VolumeMesh, wanted: Wanted) -> bytes:
    """A scene: fixed nodes are held; the other sets are nodes that are not active, to be used as they are needed."""
    root = Xml.Element("Node", name="root", dt="0.02", gravity=_line(GRAVITY * wanted.down))
    for plugin in SOFA_PLUGINS:
        Xml.SubElement(root, "RequiredPlugin", name=f"Sofa.Component.{plugin}")
    Xml.SubElement(root, "DefaultAnimationLoop")
    body = Xml.SubElement(root, "Node", name="torso")
    Xml.SubElement(body, "EulerImplicitSolver", rayleighStiffness="0.1", rayleighMass="0.1")
    Xml.SubElement(body, "CGLinearSolver", iterations="200", tolerance="1e-9", threshold="1e-9")
    container, places = "TetrahedronSetTopologyContainer", _rows(mesh.points)
    Xml.SubElement(body, container, name="mesh", position=places, tetrahedra=_rows(mesh.tetrahedra))
    Xml.SubElement(body, "TetrahedronSetGeometryAlgorithms", template="Vec3")
    Xml.SubElement(body, "MechanicalObject", name="state", template="Vec3", src="@mesh")
    Xml.SubElement(body, "MeshMatrixMass", massDensity=str(DENSITY), topology="@mesh")
    stiff = {"method": "large", "youngModulus": str(YOUNG), "poissonRatio": str(POISSON)}
    for name in REGIONS:
        Xml.SubElement(body, container, name=name, tetrahedra=_rows(mesh.tetrahedra[mesh.inside(name)]))
        Xml.SubElement(body, "TetrahedronFEMForceField", stiff, name=f"{name}_tissue", topology=f"@{name}")
    for name, nodes in mesh.node_sets.items():
        place = body if name == "fixed" else Xml.SubElement(body, "Node", name=f"{name}_nodes", activated="0")
        Xml.SubElement(place, "FixedProjectiveConstraint", name=name, mstate="@/torso/state", indices=_line(nodes))
    return _document(root)


def _febio(mesh: VolumeMesh, wanted: Wanted) -> bytes:
    """A model of FEBio 4: a neo-Hookean material for each region, the fixed nodes held, gravity in ten steps."""
    root = Xml.Element("febio_spec", version="4.0")
    Xml.SubElement(root, "Module", type="solid")
    control = Xml.SubElement(root, "Control")
    for name, value in (("analysis", "STATIC"), ("time_steps", "10"), ("step_size", "0.1")):
        Xml.SubElement(control, name).text = value
    Xml.SubElement(control, "solver", type="solid")
    materials, geometry = Xml.SubElement(root, "Material"), Xml.SubElement(root, "Mesh")
    nodes = Xml.SubElement(geometry, "Nodes", name="torso")
    for number, place in enumerate(mesh.points, start=1):
        Xml.SubElement(nodes, "node", id=str(number)).text = _line(place, ",")
    domains = Xml.Element("MeshDomains")
    for number, name in enumerate(REGIONS, start=1):
        material = Xml.SubElement(materials, "material", id=str(number), name=name, type="neo-Hookean")
        for key, number_of in (("density", DENSITY), ("E", YOUNG), ("v", POISSON)):
            Xml.SubElement(material, key).text = str(number_of)
        elements = Xml.SubElement(geometry, "Elements", type="tet4", name=name)
        for index in np.flatnonzero(mesh.inside(name)):
            Xml.SubElement(elements, "elem", id=str(index + 1)).text = _line(mesh.tetrahedra[index] + 1, ",")
        Xml.SubElement(domains, "SolidDomain", name=name, mat=name)
    for name, triangles in zip(SURFACES, (mesh.surface, mesh.wall), strict=True):
        surface = Xml.SubElement(geometry, "Surface", name=name)
        for number, corners in enumerate(triangles, start=1):
            Xml.SubElement(surface, "tri3", id=str(number)).text = _line(corners + 1, ",")
    for name, members in mesh.node_sets.items():
        Xml.SubElement(geometry, "NodeSet", name=name).text = _line(members + 1, ",")
    root.append(domains)
    held = Xml.SubElement(
        Xml.SubElement(root, "Boundary"), "bc", name="fixed", type="zero displacement", node_set="fixed"
    )
    for axis in "xyz":
        Xml.SubElement(held, f"{axis}_dof").text = "1"
    weight = Xml.SubElement(Xml.SubElement(root, "Loads"), "body_load", name="weight", type="body force")
    Xml.SubElement(weight, "force", lc="1").text = _line(-GRAVITY * wanted.down, ",")  # FEBio subtracts it
    data = Xml.SubElement(root, "LoadData")
    curve = Xml.SubElement(data, "load_controller", id="1", name="ramp", type="loadcurve")
    Xml.SubElement(curve, "interpolate").text = "LINEAR"
    points = Xml.SubElement(curve, "points")
    for at in ("0,0", "1,1"):
        Xml.SubElement(points, "pt").text = at
    plot = Xml.SubElement(Xml.SubElement(root, "Output"), "plotfile", type="febio")
    Xml.SubElement(plot, "var", type="displacement")
    return _document(root)


def _document(root: Xml.Element) -> bytes:
    root.insert(0, Xml.Comment(f" {LIMITS_OF_USE} "))
    Xml.indent(root, " ")
    return bytes(Xml.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _rows(numbers: Any) -> str:
    return "\n".join(_line(row) for row in numbers)


def _line(numbers: Any, between: str = " ") -> str:
    return between.join(f"{number:.9g}" for number in np.asarray(numbers).tolist())


WRITERS: dict[str, Callable[[VolumeMesh, Wanted], bytes]] = {".vtu": _vtu, ".msh": _msh, ".scn": _sofa, ".feb": _febio}
