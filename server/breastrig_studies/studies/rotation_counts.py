"""The numbers of random orientations per scan."""

ROTATIONS, QUICK_ROTATIONS = 24, 4
