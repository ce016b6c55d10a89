"""Patterns in the patient's own millimetres: each a class that knows its parameters and draws itself on her skin."""
