"""`breastrig serve` with the example patient in BREASTRIG_E2E_EXAMPLES: run as a program by the browser tests.

What was read, proposed or fitted before in this run is not made again (see helpers/remembered_*.py): the page gets the
same answers, and the same events at the same times after each other.
"""

import os
import sys

from breastrig.core import assets
from breastrig.execution.worker import preload
from breastrig.workflow import tasks
from helpers import remembered_fits, remembered_proposals
from helpers.remembered_uploads import remember_uploads

if __name__ == "__main__":
    assets.CHECKOUT["example"] = os.environ["BREASTRIG_E2E_EXAMPLES"]
    tasks.run_fit, tasks.propose_on_file = remembered_fits.run_fit_once, remembered_proposals.propose_once  # type: ignore[assignment]
    from breastrig.cli.main import main  # takes them from there

    remember_uploads()
    preload([remembered_fits.__name__, remembered_proposals.__name__])
    sys.exit(main())
