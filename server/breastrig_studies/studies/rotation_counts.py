"""How many random orientations of each scan are tried."""

ROTATIONS, QUICK_ROTATIONS = 24, 4
