"""`breastrig serve` with fits that need no numerics: run as a program by the tests of the real server.

Processes of tasks import this file too, so that what the server alone needs is imported where the program begins.
"""

import os
import sys
from datetime import timedelta

from breastrig.core import wall_clock
from helpers import fake_fit


def set_clock_ahead(days: float) -> None:
    """As if somebody had set the machine's clock before the start."""
    now = wall_clock.now
    wall_clock.now = lambda: now() + timedelta(days=days)


if __name__ == "__main__":
    from breastrig.cli import serve_command
    from breastrig.cli.main import main
    from breastrig.service import service, sweep
    from helpers.light_tasks import LIGHT_TASK_MODULES
    from helpers.remembered_uploads import remember_uploads

    service.TASK_MODULES = LIGHT_TASK_MODULES
    set_clock_ahead(float(os.environ.get("FAKE_DAYS_AHEAD", "0")))
    sweep.LOOK_EVERY_S = float(os.environ.get("FAKE_LOOK_EVERY_S", sweep.LOOK_EVERY_S))
    sweep.RETRY_EVERY_S = min(sweep.RETRY_EVERY_S, sweep.LOOK_EVERY_S)
    remember_uploads()
    serve_command.run_fit = getattr(fake_fit, os.environ.get("FAKE_FIT", "mostly_patient"))
    with_token = {"BREASTRIG_TOKEN", "FAKE_TOKEN"} & os.environ.keys() or "--token-file" in sys.argv
    sys.exit(main(["serve", *([] if with_token else ["--no-token"]), *sys.argv[1:]]))
