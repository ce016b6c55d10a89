"""Judges whether a finished fit can be trusted: its signals and their combination."""
