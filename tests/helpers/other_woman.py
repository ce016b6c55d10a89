"""Another woman's scans, of the virtual cohort: python tests/helpers/other_woman.py FOLDER."""

import sys
from pathlib import Path

from breastrig_studies.virtual.make import make_cohort

OTHER = "patient_3"  # of another build than the example, as most are; not her landmarks, but her skin says so

if __name__ == "__main__":
    make_cohort(Path(sys.argv[1]), lambda _: None, [OTHER])
