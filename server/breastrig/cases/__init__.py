"""A case is a folder: all that is kept of one patient, as documents and meshes."""
