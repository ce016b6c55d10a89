"""Volumes in files of one grid: NIfTI, NRRD, MetaImage."""
