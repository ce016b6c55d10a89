"""Handles of a pattern that can be dragged on the skin: each sets one parameter and computes its value at a place."""
