"""Measures of a fitted body as numbers, pictures, tables and sheets."""
