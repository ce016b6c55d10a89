"""Lesions and other places inside the body."""
