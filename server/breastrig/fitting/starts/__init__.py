"""Starts of fits without landmarks: the rest pose tried all around, and on a part of a body at a few heights."""
