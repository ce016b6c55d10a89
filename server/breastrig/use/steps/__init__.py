"""The steps of one fit: its scan made ready, its iterates recorded, its events."""
