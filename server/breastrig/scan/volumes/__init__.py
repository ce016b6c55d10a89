"""Scans that are volumes: the skin is made here."""
