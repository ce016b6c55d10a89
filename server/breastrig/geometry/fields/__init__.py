"""Scalar fields over a box of space or a surface: distances, the surface where one is zero, level sets."""
