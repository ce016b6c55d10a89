"""A scanning session of one stance: the camera's path, and the parts that the scan leaves out.

Everything is drawn from the given generator within the limits of what people do: how far they walk around, how low and
high the scanning box reaches, how much of each arm is inside, and where wet or shining skin gives no answer.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.depth_camera import DepthCamera, View, look_at

AWAY = 0.66  # m from the body's axis to the camera: its picture is then as wide as a trunk
UP = np.array([0.0, 1.0, 0.0])
CAMERA = DepthCamera(noise=0.0015, wave=0.0013, shift=0.0021, turn=0.0026)  # held by hand, so that it drifts
# Heights of the camera and of what it looks at, as shares of the way from navel to notch.
STANDING_ROWS = ((-0.35, 0.05), (0.15, 0.15), (0.65, 0.55), (1.3, 0.85), (2.0, 0.95))
LYING_ROWS = (-0.6, -0.1, 0.45, 1.0, 1.45)
FREE = 0.035  # m around each landmark where the skin is neither wet nor shining
TABLE = 0.36  # m, half its width


@dataclass(frozen=True, eq=False)
class Session:
    """One scanning session, in body coordinates."""

    camera: DepthCamera
    views: list[View]
    low: Array  # (3,) m, the scanning box
    high: Array
    blind_spots: Array  # (M, 4): centre and radius (m)


def plan_session(body: VirtualBody, skin: Booleans, random: np.random.Generator) -> Session:
    """A session around a body; blind spots lie on the (V,) bool skin that a scan can show."""
    navel, notch = body.landmarks["umbilicus"][1], body.landmarks["suprasternal_notch"][1]
    low, high = navel - random.uniform(0.07, 0.13), notch + random.uniform(0.03, 0.05)
    right, left = random.uniform(0.27, 0.34, 2)
    if body.table is None:
        views = _around(navel, notch, np.radians(random.uniform(85.0, 110.0)))
        depths = (-0.17, 0.32)
    else:
        views = _above(navel, notch, body.table, np.radians(random.uniform(66.0, 78.0)))
        depths = (body.table - 0.02, body.table + 0.36)
    return Session(
        CAMERA,
        views,
        np.array([-right, low, depths[0]]),
        np.array([left, high, depths[1]]),
        _blind_spots(body, skin & (body.vertices[:, 2] > 0.0), random),
    )


def table_top(depth: float) -> tuple[Array, Integers]:
    """((V, 3) m, (F, 3)): the upper side of a table at z = depth (m), in squares of 3 cm."""
    x, y = np.meshgrid(np.linspace(-TABLE, TABLE, 25), np.linspace(-0.6, 0.9, 51), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return np.stack([x.ravel(), y.ravel(), np.full(x.size, depth)], axis=1), faces


def _around(navel: float, notch: float, reach: float) -> list[View]:
    """Rows of an arc around the front; `reach` (rad) to each side, so that the middle of the back is unseen."""
    views = []
    for row, (height, aim) in enumerate(STANDING_ROWS):
        for azimuth in np.linspace(-reach, reach, 11) + 0.05 * (row - 2):
            away = np.array([AWAY * np.sin(azimuth), navel + height * (notch - navel), AWAY * np.cos(azimuth) + 0.02])
            views.append(look_at(away, np.array([0.0, navel + aim * (notch - navel), 0.02]), UP))
    return views


def _above(navel: float, notch: float, table: float, reach: float) -> list[View]:
    """Arcs over the table, and two looks along it past head and feet on each side."""
    views = []
    for height in LYING_ROWS:
        for azimuth in np.linspace(-reach, reach, 9):
            y = navel + height * (notch - navel)
            away = np.array([AWAY * np.sin(azimuth), y, AWAY * np.cos(azimuth)])
            views.append(look_at(away, np.array([0.0, 0.5 * (y + navel) + 0.05, 0.02]), UP))
    for side in (-0.25, 0.25):
        for head, aim in ((notch + 0.45, notch - 0.05), (navel - 0.5, navel)):
            views.append(look_at(np.array([side, head, table + 0.44]), np.array([0.5 * side, aim, 0.0]), UP))
    return views


def _blind_spots(body: VirtualBody, skin: Booleans, random: np.random.Generator) -> Array:
    """(18, 4) m: three blotches of irregular form, six discs each; nobody keeps a scan without its landmarks."""
    away, _ = cKDTree(np.array(list(body.landmarks.values()))).query(body.vertices)
    places = body.vertices[random.choice(np.flatnonzero(skin & (away > FREE)), 3, replace=False)]
    centres = np.repeat(places, 6, axis=0) + 0.010 * random.standard_normal((18, 3))
    return np.column_stack([centres, random.uniform(0.005, 0.012, 18)])
