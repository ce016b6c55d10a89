"""Meshes without meaning: rotations, normals, closest points, rays, curves."""

import breastrig.core.scipy_parts  # noqa: F401  before libigl, which would load all of SciPy
