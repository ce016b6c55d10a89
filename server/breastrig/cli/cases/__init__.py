"""The actions of `breastrig case`."""
