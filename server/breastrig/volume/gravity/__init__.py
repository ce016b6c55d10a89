"""Soft tissue under gravity: hyperelastic statics by finite elements."""
