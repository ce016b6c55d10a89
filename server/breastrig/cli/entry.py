"""Entry point of the program `breastrig`: handles Ctrl-C before anything else is imported."""

import gc
import os
import sys

from breastrig.cli.interruption import watch


def entry() -> None:
    """Runs the command of the process's arguments and leaves with its exit code."""
    watch()
    gc.disable()  # until the command is loaded (see main): a tenth of that time would be a search for nothing
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # we use none, and all that is installed is searched
    from breastrig.cli.main import main

    sys.exit(main())


if __name__ == "__main__":
    entry()
