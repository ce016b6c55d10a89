"""Landmarks observed in a scan, without picks."""
