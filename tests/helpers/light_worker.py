"""`breastrig worker` whose tasks are stand-ins, imported beforehand: run as a program by tests of clusters."""

import sys

if __name__ == "__main__":
    from breastrig.cli import worker_command
    from breastrig.cli.main import main

    worker_command.TASK_MODULES = ("helpers.in_worker", "helpers.fake_batch")
    sys.exit(main(["worker", *sys.argv[1:]]))
