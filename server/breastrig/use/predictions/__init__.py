"""Stances that were not scanned."""
