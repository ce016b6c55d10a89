"""The door to the 3D world: rigs, iterations, whole fits and scans as glTF."""
