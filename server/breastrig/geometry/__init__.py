"""Meshes without meaning: rotations, normals, closest points, rays, curves."""
