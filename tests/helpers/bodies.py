"""Bodies that are no torsos, of the size of one: what somebody may upload by mistake, or to see what happens."""

import numpy as np
import trimesh
from hypothesis import strategies as st

from helpers.subdivide import subdivided

Mesh = tuple[np.ndarray, np.ndarray]

EDGE = 0.020  # m, at most, of a scan's triangles
NOISE = 0.0015  # m, of a depth camera


def plate(random: np.random.Generator) -> Mesh:
    """A slab, a sheet without thickness, or a wave."""
    side, height = 0.8, float(random.choice([0.0, 0.002, 0.05]))
    x, y = np.meshgrid(np.linspace(-side / 2, side / 2, 25), np.linspace(-side / 2, side / 2, 25))
    z = height * np.sin(7.0 * x + random.uniform(0.0, 6.0))
    corner = (np.arange(24)[:, None] * 25 + np.arange(24)).ravel()
    quads = np.stack([corner, corner + 1, corner + 26, corner + 25], axis=1)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def of_library(mesh: trimesh.Trimesh) -> Mesh:
    return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)


def soup(random: np.random.Generator) -> Mesh:
    return random.uniform(-0.4, 0.4, (300, 3)), random.integers(0, 300, (400, 3))


def hull(random: np.random.Generator) -> Mesh:
    return of_library(trimesh.convex.convex_hull(random.normal(size=(int(random.integers(8, 300)), 3)) * 0.25))


def crumpled(random: np.random.Generator) -> Mesh:
    vertices, faces = of_library(trimesh.creation.icosphere(3, 0.35))
    return vertices * random.uniform(0.5, 1.5, (len(vertices), 1)), faces


def half(random: np.random.Generator) -> Mesh:
    """One side of a ball or barrel, as a scan from one place shows it."""
    vertices, faces = ball(random)
    return vertices, faces[vertices[faces].mean(axis=1) @ random.normal(size=3) > 0.0]


def ball(random: np.random.Generator) -> Mesh:
    return of_library(trimesh.creation.icosphere(3, float(random.uniform(0.2, 0.6))))


def many(random: np.random.Generator) -> Mesh:
    """Several balls beside each other."""
    parts = [trimesh.creation.icosphere(2, 0.1) for _ in range(9)]
    for part in parts:
        part.apply_translation(random.uniform(-0.4, 0.4, 3))
    return of_library(trimesh.util.concatenate(parts))


def thin(random: np.random.Generator) -> Mesh:
    """A stick."""
    return of_library(trimesh.creation.cylinder(float(random.uniform(1e-4, 0.02)), 0.9, sections=64))


BODIES = {
    "plate": plate,
    "ball": ball,
    "half": half,
    "box": lambda random: of_library(trimesh.creation.box(random.uniform(0.2, 0.8, 3))),
    "cylinder": lambda random: of_library(trimesh.creation.cylinder(0.2, float(random.uniform(0.3, 0.9)))),
    "prism": lambda random: of_library(trimesh.creation.cylinder(0.3, 0.6, sections=int(random.integers(3, 9)))),
    "cone": lambda random: of_library(trimesh.creation.cone(0.3, float(random.uniform(0.3, 0.9)))),
    "ring": lambda random: of_library(trimesh.creation.torus(0.3, float(random.uniform(0.02, 0.2)))),
    "stick": thin,
    "hull": hull,
    "crumpled": crumpled,
    "soup": soup,
    "many": many,
}


def body(kind: str, seed: int, divisions: int) -> Mesh:
    """A body of BODIES, turned at random, each triangle divided in four so many times."""
    random = np.random.default_rng(seed)
    vertices, faces = BODIES[kind](random)
    for _ in range(divisions):
        vertices, faces = subdivided(vertices, faces)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return vertices @ turn, faces


def scanned(kind: str, seed: int) -> Mesh:
    """A body as dense as a scan and with a scanner's noise; unturned."""
    random = np.random.default_rng(seed)
    vertices, faces = trimesh.remesh.subdivide_to_size(*BODIES[kind](random), EDGE, max_iter=30)
    return vertices + random.normal(scale=NOISE, size=vertices.shape), faces


def any_body() -> st.SearchStrategy[tuple[str, int, int]]:
    """Arguments of `body`."""
    return st.tuples(st.sampled_from(sorted(BODIES)), st.integers(0, 2**32 - 1), st.integers(0, 1))
