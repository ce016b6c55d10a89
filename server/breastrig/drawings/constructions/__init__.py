"""Patterns in millimetres on the patient's skin: each a class that knows its parameters and draws itself."""
