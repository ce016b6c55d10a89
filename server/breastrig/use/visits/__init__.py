"""Visits of one patient over time."""
