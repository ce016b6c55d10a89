"""Checks a person's picks against the rest of the fit, and decides which are followed."""
