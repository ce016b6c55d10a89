"""BreastRig: one rigged torso model fitted to 3D scans. Research use only, not a medical device."""

__version__ = "0.1.0"
