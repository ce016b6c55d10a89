"""Starts of a fit that need more than a look at the scan."""
