"""The files that an export writes: meshes, lines, numbers by vertex, in the scan's frame."""
