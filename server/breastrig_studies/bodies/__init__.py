"""Statistics of bodies beyond the rig, estimated on virtual ones whose whole skin is known."""
