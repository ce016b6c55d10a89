"""`breastrig serve` with the example patient in BREASTRIG_E2E_EXAMPLES: run as a program by the browser tests.

An upload that was read before in this run is not read again (helpers.remembered_uploads), and the same fit of it is not
made again but comes as it came before, in the same time (helpers.remembered_fits); landmarks are proposed on it once.

Processes of tasks import this file too, so that what the server alone needs is imported where the program begins.
"""

import os
import sys

if __name__ == "__main__":
    from breastrig.cli import serve_command
    from breastrig.cli.main import main
    from breastrig.core import assets
    from helpers.remembered_fits import run_fit_once, run_pair_once
    from helpers.remembered_proposals import propose_once
    from helpers.remembered_uploads import remember_uploads

    assets.CHECKOUT["example"] = os.environ["BREASTRIG_E2E_EXAMPLES"]
    remember_uploads()
    serve_command.propose_on_file = propose_once
    serve_command.run_fit, serve_command.run_pair = run_fit_once, run_pair_once
    sys.exit(main())
