"""The model itself as a patient: at rest, where both sides are one, and as an asymmetric woman."""

import numpy as np
import pytest
from helpers.subdivide import subdivided

from breastrig.geometry.polyline import Polyline
from breastrig.report.stance import Stance
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose


def stance_on(rig: Rig, vertices: np.ndarray, picked: dict[str, np.ndarray] | None = None) -> Stance:
    """A fit that lies on its scan exactly, with the first drawing."""
    scan, faces = subdivided(vertices, rig.faces)
    lines = tuple(
        Polyline(s.name, s.closed, s.color, s.points.positions(vertices, rig.faces), np.zeros(len(s.points), bool))
        for s in rig.drawings[0].shapes
    )
    return Stance(rig, vertices, scan, faces, "standing", picked or {}, lines)


@pytest.fixture(scope="session")
def at_rest(rig: Rig) -> Stance:
    return stance_on(rig, np.array(rig.template))


@pytest.fixture(scope="session")
def asymmetric(rig: Rig) -> Stance:
    """Her left breast is larger and lower."""
    rest = rest_parameters(rig)
    weights = np.zeros(len(rig.shapes))
    for name, weight in (("volume_large_L", 0.9), ("ptosis_L", 0.8), ("projection_R", 0.5), ("base_width_R", -0.5)):
        weights[rig.shape_names.index(name)] = weight
    return stance_on(rig, pose(rig, RigParameters(rest.rotations, rest.translations, rest.scales, weights)))


@pytest.fixture(scope="session")
def mirrored(rig: Rig, asymmetric: Stance) -> Stance:
    return stance_on(rig, (asymmetric.vertices * [-1.0, 1.0, 1.0])[rig.mirror_vertices])
