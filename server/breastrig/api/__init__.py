"""HTTP: the only place which imports Flask."""
