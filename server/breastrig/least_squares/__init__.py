"""Nonlinear least squares with constraints and bounds; knows nothing of bodies."""
