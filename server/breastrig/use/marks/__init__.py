"""Marks that the colours of two scans show."""
