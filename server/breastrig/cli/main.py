"""`breastrig` and its commands.  Exit codes: 0 done, 1 the fit failed, 2 bad input or usage, 3 written but not
usable, 130 stopped by Ctrl-C.

Only the module of the command that is called is imported.
"""

import argparse
import gc
import os
import sys
from collections.abc import Sequence
from typing import Any

from breastrig.cli import interruption
from breastrig.cli.commands import COMMANDS, further_commands, further_module, own_module
from breastrig.core.errors import BadInput, BreastRigError, NeedsAnswer, NeedsYes
from breastrig.core.notice import LIMITS_OF_USE, RESEARCH_USE_ONLY
from breastrig.core.private_files import shown
from breastrig.core.version import __version__


def parser(command: str | None = None, *, lists_all: bool = True) -> argparse.ArgumentParser:
    """The parser with the options of the command that is called; without one with all commands, or with our own."""
    root = argparse.ArgumentParser(
        prog="breastrig",
        description="Fits a rigged torso model to a 3D scan and lays surgical drawings on it.",
        epilog=LIMITS_OF_USE,
    )
    root.add_argument("--version", action="version", version=f"BreastRig {__version__}. {RESEARCH_USE_ONLY}")
    parsers = root.add_subparsers(dest="command", required=True, metavar="COMMAND")
    if command is not None:
        module = _module(command)
        module.add_options(parsers.add_parser(command, description=module.__doc__))
    else:
        for name, what in (COMMANDS | (further_commands() if lists_all else {})).items():
            parsers.add_parser(name, help=what)
    return root


def _module(command: str) -> Any:
    return own_module(command) if command in COMMANDS else further_module(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command; every expected error is one line on stderr."""
    words = sys.argv[1:] if arguments is None else arguments
    before = os.umask(0o077)  # results show patients: whatever a command writes is for its user alone
    try:
        named = words[0] if words else ""
        known = named in COMMANDS or (not named.startswith("-") and named in further_commands())
        options = parser(named if known else None, lists_all=named != "--version").parse_args(words)
        interruption.work_begins()
        if not gc.isenabled():  # what was loaded is there to the end, and need not be looked through again
            gc.freeze()
            gc.enable()
        return int(_module(options.command).run(options))
    except BreastRigError as error:
        said = error.on_command_line() if isinstance(error, NeedsAnswer | NeedsYes) else error
        print(f"breastrig: {said}", file=sys.stderr)
        return 2 if isinstance(error, BadInput) else 1
    except BrokenPipeError:
        return 1
    except KeyboardInterrupt:
        print("breastrig: stopped.", file=sys.stderr)
        return interruption.exit_code()
    except OSError as error:
        if error.filename is None:
            raise
        print(f"breastrig: {shown(str(error.filename))} cannot be used ({error.strerror}).", file=sys.stderr)
        return 2
    finally:
        os.umask(before)


if __name__ == "__main__":
    interruption.watch()
    sys.exit(main())
