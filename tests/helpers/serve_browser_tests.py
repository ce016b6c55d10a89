"""`breastrig serve` with the example patient in BREASTRIG_E2E_EXAMPLES: run as a program by the browser tests.

An upload that was read before in this run is not read again (helpers.remembered_uploads).
"""

import os
import sys

from breastrig.cli.main import main
from breastrig.core import assets
from helpers.remembered_uploads import remember_uploads

if __name__ == "__main__":
    assets.CHECKOUT["example"] = os.environ["BREASTRIG_E2E_EXAMPLES"]
    remember_uploads()
    sys.exit(main())
