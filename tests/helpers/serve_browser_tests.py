"""`breastrig serve` with the example patient in BREASTRIG_E2E_EXAMPLES: run as a program by the browser tests.

What was read, proposed or fitted before in this run is not made again (see helpers/remembered_*.py): the page gets the
same answers, and the same events at the same times after each other.  Reports are without their pictures, and so are
their pages where BREASTRIG_PLAIN_PAGES is set.
"""

import os
import sys

from breastrig.core import assets
from breastrig.execution.worker import preload
from breastrig.use import fit, landmarks
from helpers import plain_report, remembered_fits, remembered_proposals
from helpers.remembered_uploads import remember_uploads

if __name__ == "__main__":
    assets.CHECKOUT["example"] = os.environ["BREASTRIG_E2E_EXAMPLES"]
    fit.run_fit = remembered_fits.run_fit_once
    landmarks.propose_on_file = remembered_proposals.propose_once
    from breastrig.cli.main import main  # takes them from there
    from breastrig.service import reports, share_snapshots

    reports.MAKERS["report.pdf"] = plain_report.plain_report_pdf_of
    if "BREASTRIG_PLAIN_PAGES" in os.environ:
        reports.MAKERS["pages.zip"] = plain_report.plain_report_pages_of
    share_snapshots.write_snapshot = plain_report.write_plain_snapshot
    remember_uploads()
    modules = [module.__name__ for module in (remembered_fits, remembered_proposals, plain_report)]
    preload([*modules, "helpers.remembering"])
    sys.exit(main())
