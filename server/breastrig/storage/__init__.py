"""Persistent storage: cases, and the index that finds them. No numerics."""
