"""Lines and surfaces of a fit as files for other programs."""
