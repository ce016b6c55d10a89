"""Nonlinear least squares with bounds; knows nothing of bodies."""
