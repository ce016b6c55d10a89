"""Writes the mean height of hidden skin above the fitted model (fitting/body), over bodies whose skin is known.

    breastrig evaluate --warped 44 COHORT -o DIR --quick
    python -m breastrig_studies.bodies.hidden_skin DIR/warped

Only bodies of the development half, fitted without landmarks. The given patients and the virtual cohort count alike,
however many each has, and each body counts as it is and mirrored. The error of the whole back's height depends on how a
body lies and how deep its trunk is, which no two of these bodies share; so the mean over each back is subtracted. Of
the rest, the back's form, only the part is kept on which both ways of computing how a body lies down agree: from the
cohort alone the error of the given patient of the development half grows by 0.6 mm.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans
from breastrig.fitting.body.refine import SCHEMA, HiddenSkin
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.boundary import boundary_vertices
from breastrig.geometry.normals import vertex_normals
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import DEVELOPMENT, read_cohort
from breastrig_studies.lying_motion import OURS, agreed, spaced
from breastrig_studies.studies.case import Scene, read_scene

Bodies = Mapping[str, Sequence[tuple[Booleans, Array]]]  # (hidden, heights) of bodies by their source

FOLDER = default_rig_path().with_suffix(".known")
APART = 0.02  # m, between the places
WIDTH = 0.03  # m, of the Gaussian over the vertices around a place
SHOWN = 0.015  # m from a scan's vertex that faces alike (cosine over one half): that skin is not hidden
EDGE = 0.008  # m from the border of the known skin: beyond it nobody knows


def hidden_heights(scene: Scene, rig: Rig, vertices: Array) -> tuple[Booleans, Array]:
    """((V,) which vertices lie where the scan shows nothing but the skin is known, (V,) m the skin's heights above)."""
    normals, truth = vertex_normals(vertices, rig.faces), scene.truth
    assert truth is not None
    gap, nearest = scene.target.vertex_tree.query(vertices)
    shown = (gap < SHOWN) & (np.einsum("vi,vi->v", normals, scene.target.normals[nearest]) > 0.5)
    found = truth.query(vertices)
    border = boundary_vertices(truth.triangles, len(truth.vertices))
    at_edge: Booleans = np.zeros(len(vertices), dtype=np.bool_)
    if border.any():
        at_edge = np.asarray(cKDTree(truth.vertices[border]).query(found.points)[0]) < EDGE
    return ~shown & ~at_edge, np.einsum("vi,vi->v", found.points - vertices, normals)


def about_the_back(rig: Rig, hidden: Booleans, heights: Array) -> Array:
    """(V,) m: the heights with those of the back less their mean over its hidden vertices."""
    back = np.isin(np.arange(len(heights)), rig.regions["back"])
    known = heights[hidden & back]
    return np.where(back, heights - (known.mean() if len(known) else 0.0), heights)


def agreed_form(rig: Rig, bodies: Bodies) -> HiddenSkin:
    """The hidden skin of lying bodies on which all sources agree, without the mean height of a whole back."""
    ways = [
        estimated(rig, {source: [(hidden, about_the_back(rig, hidden, heights)) for hidden, heights in given]})
        for source, given in bodies.items()
    ]
    return replace(ways[0], heights=agreed([way.heights for way in ways]))


def estimated(rig: Rig, bodies: Bodies) -> HiddenSkin:
    """The mean over the sources."""
    means, shares = [], []
    for given in bodies.values():
        total, times = np.zeros(len(rig.template)), np.zeros(len(rig.template))
        for hidden, heights in given:
            for side in (slice(None), rig.mirror_vertices):
                total += np.where(hidden, heights, 0.0)[side]
                times += hidden[side]
        means.append(total / np.maximum(times, 1.0))
        shares.append(times / (2.0 * len(given)))
    return smoothed(rig, np.mean(means, axis=0), np.min(shares, axis=0))


def smoothed(rig: Rig, values: Array, share: Array) -> HiddenSkin:
    """Places of the left side with what (V,) `values` are around them, times the (V,) share that is known."""
    normals = vertex_normals(rig.template, rig.faces)
    left = np.flatnonzero(rig.template[:, 0] >= 0.0)
    chosen = left[spaced(rig.template[left], APART)]
    tree, smooth = cKDTree(rig.template), np.zeros(len(chosen))
    for k, vertex in enumerate(chosen):
        near = np.asarray(tree.query_ball_point(rig.template[vertex], 2.5 * WIDTH), dtype=np.int64)
        apart = np.linalg.norm(rig.template[near] - rig.template[vertex], axis=1)
        weight = np.exp(-0.5 * (apart / WIDTH) ** 2) * np.maximum(normals[near] @ normals[vertex], 0.0)
        smooth[k] = (weight * share[near]) @ values[near] / weight.sum()
    return HiddenSkin(rig.template[chosen], normals[chosen], smooth)


def main(folder: Path, into: Path = FOLDER) -> None:
    """Fits the folder's bodies and writes a file for each stance."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    bodies: dict[str, dict[str, list[tuple[Booleans, Array]]]] = {"standing": {}, "supine": {}}
    for case in read_cohort(folder):
        patient = json.loads((folder / case.patient / "patient.json").read_text("utf-8"))
        if case.group == DEVELOPMENT and patient["capture"] == "ordinary":
            scene = read_scene(case)
            found = hidden_heights(scene, rig, scene.fitted(rig, recipe, {}).vertices)
            bodies[case.stance].setdefault("ours" if patient["source"].startswith(OURS) else "given", []).append(found)
    for stance, given in bodies.items():
        skin = agreed_form(rig, given) if stance == "supine" else estimated(rig, given)
        document = {
            "schema": SCHEMA,
            "bodies": {source: len(of_source) for source, of_source in given.items()},
            "places_mm": np.round(1e3 * skin.places, 1).tolist(),
            "normals": np.round(skin.normals, 3).tolist(),
            "heights_mm": np.round(1e3 * skin.heights, 2).tolist(),
        }
        (into / f"hidden_{stance}.json").write_text(json.dumps(document) + "\n", "utf-8")


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER")
    main(Path(given.folder))
