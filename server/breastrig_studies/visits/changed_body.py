"""One body at a later visit: changed by a known amount, and standing or lying a little differently.

Changes are of the skin alone: a breast larger or smaller by so many ml, a dent as a resection leaves it, or more weight
everywhere.  Posture (the trunk bent and twisted, ribs lifted by a breath, shoulders up or down) is no change of a
breast: it is what a comparison has to bear.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import spsolve
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.half_edges import neighbours
from breastrig.geometry.normals import vertex_normals
from breastrig.report.volume import enclosed_volume
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.warped.body import breast_region, is_sound
from breastrig_studies.virtual.warped.sources import Source

SMOOTHED = 12  # rounds of averaging of the normals along which skin moves
DENT_ASIDE, DENT_FLANK = (0.015, 0.045), (0.022, 0.034)  # m from the nipple; m, standard deviation of its bell
BENT, BREATH, SHOULDERS = 1.5, 0.008, 0.004  # standard deviations: degrees at the notch, share of depth, m
BODY_WEIGHT = {"belly": 1.0, "chest": 0.4, "breast": 1.5}  # of `mm`, along the normals


@dataclass(frozen=True)
class Change:
    """What became of a body between two visits."""

    kind: str  # same | volume | dent | weight
    side: str = ""  # L | R, of the breast that changed; both: ""
    ml: float = 0.0  # of that breast
    mm: float = 0.0  # of the belly's skin


def draw_change(kind: str, random: np.random.Generator) -> Change:
    """A change of this kind: 10 to 200 ml of a breast, 5 to 40 ml out of one, 2 to 6 mm of weight."""
    side = ("L", "R")[int(random.integers(2))]
    if kind == "volume":
        return Change(kind, side, float(np.exp(random.uniform(np.log(10.0), np.log(200.0))) * random.choice((-1, 1))))
    if kind == "dent":
        return Change(kind, side, -float(np.exp(random.uniform(np.log(5.0), np.log(40.0)))))
    return Change(kind, mm=float(random.uniform(2.0, 6.0) * random.choice((-1, 1))) if kind == "weight" else 0.0)


def breasts(source: Source, standing: Array) -> dict[str, Booleans]:
    """(V,) the skin of each breast, by side."""
    at = source.landmarks(standing)
    middle = float(at["xiphoid"][0])
    return {
        side: breast_region(standing, source.faces, at[f"nipple_{side}"], at[f"inframammary_fold_{side}"], middle)
        for side in ("L", "R")
    }


def changed(
    source: Source, before: Array, of: dict[str, Booleans], change: Change, random: np.random.Generator
) -> Array | None:
    """(V, 3) m skin after the change, in the posture of `before`, its volume changed by `ml` exactly; None: it tore."""
    out = _smooth_normals(before, source.faces)
    if change.kind == "weight":
        return before + 1e-3 * change.mm * _weight(source, before, of)[:, None] * out
    if not change.ml:
        return before
    way = membrane(before, source.faces, of[change.side])
    if change.kind == "dent":
        nipple = source.landmarks(before)[f"nipple_{change.side}"]
        away = np.linalg.norm(before - nipple, axis=1)
        ring = of[change.side] & (away > DENT_ASIDE[0]) & (away < DENT_ASIDE[1]) & (way > 0.3 * way.max())
        centre = before[random.choice(np.flatnonzero(ring))]
        bell = np.exp(-0.5 * ((before - centre) ** 2).sum(axis=1) / random.uniform(*DENT_FLANK) ** 2)
        way = bell * np.minimum(way / (0.5 * way.max()), 1.0)
    start, amount = enclosed_volume(before, source.faces), 0.0
    for _ in range(6):
        found = before + amount * way[:, None] * out
        slope = (
            enclosed_volume(found + 1e-4 * way[:, None] * out, source.faces) - enclosed_volume(found, source.faces)
        ) / 1e-4
        amount += (1e-6 * change.ml - enclosed_volume(found, source.faces) + start) / slope
    after = before + amount * way[:, None] * out
    return after if is_sound(before, after, source.faces) else None


def membrane(vertices: Array, faces: Integers, region: Booleans) -> Array:
    """(V,) heights of a soap film blown up over the region, at most 1; 0 outside and at its border."""
    links = csr_array(neighbours(faces, len(vertices)))
    links.data[:] = 1.0
    laplacian = csr_array(diags_array(np.asarray(links.sum(axis=1)).ravel()) - links)
    inner = np.flatnonzero(region)
    matrix = (laplacian @ laplacian)[inner][:, inner]  # clamped: no crease at the border
    height = np.zeros(len(vertices))
    height[inner] = np.maximum(spsolve(matrix.tocsc(), np.ones(len(inner))), 0.0)
    return height / max(float(height.max()), 1e-12)


def in_posture(body: VirtualBody, vertices: Array, random: np.random.Generator) -> Array:
    """(V, 3) m with the trunk bent, leant and twisted from the navel up, a breath in the ribs, and shoulders moved."""
    low, high = body.landmarks["umbilicus"][1], body.landmarks["suprasternal_notch"][1]
    share = np.clip((vertices[:, 1] - low) / (high - low), 0.0, 1.3)
    result = vertices.copy()
    result[:, 2] += BREATH * random.standard_normal() * vertices[:, 2] * np.exp(-0.5 * ((share - 0.6) / 0.4) ** 2)
    beside = np.clip(np.abs(vertices[:, 0]) / 0.17, 0.0, 1.0) ** 2 * np.clip((share - 0.7) / 0.4, 0.0, 1.0)
    result[:, 1] += SHOULDERS * random.standard_normal() * beside
    turns = Rotation.from_rotvec(np.radians(BENT) * share[:, None] * random.standard_normal(3))
    at = np.array([0.0, low, 0.0])
    return np.asarray(turns.apply(result - at) + at)


def at_visit(source: Source, body: VirtualBody, vertices: Array, random: np.random.Generator) -> VirtualBody:
    """The body with this skin as somebody stands or lies at a visit; landmarks go with the skin."""
    skin = in_posture(body, vertices, random)
    places = {name: at for name, at in source.landmarks(skin).items() if name in body.landmarks}
    table = None if body.table is None else body.table + float(np.quantile(skin[:, 2] - vertices[:, 2], 0.1))
    return VirtualBody(body.stance, skin, places, table)


def _smooth_normals(vertices: Array, faces: Integers) -> Array:
    links = csr_array(neighbours(faces, len(vertices)))
    links.data[:] = 1.0
    normals = vertex_normals(vertices, faces)
    for _ in range(SMOOTHED):
        normals = normals + links @ normals
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return np.asarray(normals)


def _weight(source: Source, vertices: Array, of: dict[str, Booleans]) -> Array:
    """(V,) share of the belly's gain; arms and neck gain a little."""
    at = source.landmarks(vertices)
    low, high = at["umbilicus"][1], at["xiphoid"][1]
    share = np.clip((high - vertices[:, 1]) / (high - low), 0.0, 1.0)
    gain = BODY_WEIGHT["chest"] + (BODY_WEIGHT["belly"] - BODY_WEIGHT["chest"]) * share
    for region in of.values():
        gain = gain + (BODY_WEIGHT["breast"] - BODY_WEIGHT["chest"]) * membrane(vertices, source.faces, region)
    return np.asarray(gain)
