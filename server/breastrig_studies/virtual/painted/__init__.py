"""Colour for the virtual cohort: skin, marks and ink painted on true bodies, and photographed into one atlas texture.

All of it is formula.  Numbers found with it say that a method does what it should; they do not say how good it is on
photographs.
"""

from breastrig_studies.virtual.painted.make import make_painted, painted_patients

__all__ = ["make_painted", "painted_patients"]
