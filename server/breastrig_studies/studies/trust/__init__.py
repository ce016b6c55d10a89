"""Calibration of a fit's own statements: radii, issues and verdict."""
