"""Scans, and what is kept of each."""
