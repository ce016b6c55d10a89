"""The same rig with more triangles: all that is said of its surface is carried over to the finer mesh."""

from dataclasses import replace

import numpy as np
import trimesh

from breastrig.rig.model import Rig


def finer(rig: Rig, where: np.ndarray | None = None) -> Rig:
    """Each triangle cut in four; with `where` (F,) only those, whose seams to their neighbours are then open.

    The surface in the rest pose stays the same, landmarks stay at their places on it.  No drawings.
    """
    count, shapes = len(rig.template), len(rig.shapes)
    chosen = np.ones(len(rig.faces), dtype=bool) if where is None else where
    inside = np.stack([np.isin(np.arange(count), vertices) for vertices in rig.regions.values()], axis=1)
    parts = [rig.template, rig.uv, rig.skin_weights, inside, rig.blendshapes.transpose(1, 0, 2).reshape(count, -1)]
    ends = np.cumsum([part.shape[1] for part in parts])[:-1]
    fine, faces = trimesh.remesh.subdivide(np.concatenate(parts, axis=1), rig.faces, np.flatnonzero(chosen))
    template, uv, skin_weights, inside, displacements = np.split(np.asarray(fine), ends, axis=1)
    children = children_of(chosen)
    landmarks = []
    for landmark in rig.landmarks:
        own = children[landmark.face]
        place = landmark.barycentric @ rig.template[rig.faces[landmark.face]]
        weights = trimesh.triangles.points_to_barycentric(template[faces[own]], np.tile(place, (len(own), 1)))
        best = int(weights.min(axis=1).argmax())  # the one that it lies in
        landmarks.append(replace(landmark, face=int(own[best]), barycentric=weights[best]))
    return replace(
        rig,
        template=template,
        faces=np.asarray(faces, dtype=np.int64),
        uv=uv,
        blendshapes=displacements.reshape(-1, shapes, 3).transpose(1, 0, 2),
        skin_weights=skin_weights,
        landmarks=tuple(landmarks),
        drawings=(),
        mirror_vertices=np.arange(len(template)),  # no fit asks for them
        regions={name: np.flatnonzero(inside[:, k] == 1.0) for k, name in enumerate(rig.regions)},
    )


def children_of(chosen: np.ndarray) -> list[np.ndarray]:
    """For each old triangle its new ones: what is not chosen comes first, then four for each that is."""
    kept = len(chosen) - int(chosen.sum())
    places = np.where(chosen, kept + 4 * (np.cumsum(chosen) - 1), np.cumsum(~chosen) - 1)
    return [place + np.arange(4 if cut else 1) for place, cut in zip(places, chosen, strict=True)]
