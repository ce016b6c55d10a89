"""The virtual cohort: seven adult women made from MakeHuman's data, standing and lying, scanned by a simulated camera.

They have the same origin as the model's template, so that they flatter it; the files and the tables say so.
"""

from breastrig_studies.virtual.make import make_cohort

__all__ = ["make_cohort"]
