"""Drawn lines between fits and scans: carried, compared, and a whole plan on one scan."""
