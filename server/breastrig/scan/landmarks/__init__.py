"""Landmarks as people write them: tables and names."""
