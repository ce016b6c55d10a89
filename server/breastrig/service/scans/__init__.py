"""Scans: uploads, searches on them, checks of their skin."""
