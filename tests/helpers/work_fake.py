"""`breastrig worker` for tasks that need no numerics: run as a program by the tests of Dask clusters."""

import sys

if __name__ == "__main__":
    from breastrig.cli import worker_command
    from breastrig.cli.main import main
    from helpers.light_tasks import LIGHT_TASK_MODULES

    worker_command.TASK_MODULES = LIGHT_TASK_MODULES
    sys.exit(main(["worker", *sys.argv[1:]]))
