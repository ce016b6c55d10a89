"""The questions put to a case: each module answers one with plain numbers, so that an answer can be kept as JSON."""
