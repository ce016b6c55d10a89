"""`breastrig` and its commands.  Exit codes: 0 done, 1 the fit failed, 2 bad input or usage, 130 stopped by Ctrl-C.

Only the module of the command that is called is imported: all of them together take seconds.
"""

import argparse
import importlib
import os
import sys
from collections.abc import Sequence

from breastrig import __version__
from breastrig.cli import interruption
from breastrig.core.errors import BadInput, BreastRigError
from breastrig.core.notice import LIMITS_OF_USE, RESEARCH_USE_ONLY
from breastrig.core.private_files import shown

COMMANDS = (
    "fit",
    "transfer",
    "compare",
    "report",
    "export",
    "landmarks",
    "batch",
    "evaluate",
    "model",
    "serve",
    "worker",
    "config",
    "purge",
)


def parser(commands: Sequence[str] = COMMANDS) -> argparse.ArgumentParser:
    """Of these commands."""
    root = argparse.ArgumentParser(
        prog="breastrig",
        description="Fits a rigged torso model to a 3D scan and lays surgical drawings on it.",
        epilog=LIMITS_OF_USE,
    )
    root.add_argument("--version", action="version", version=f"BreastRig {__version__}. {RESEARCH_USE_ONLY}")
    parsers = root.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in commands:
        importlib.import_module(f"breastrig.cli.{command}_command").add_parser(parsers)
    return root


def _needed(words: Sequence[str]) -> Sequence[str]:
    """The commands that these words are about."""
    if words and words[0] in COMMANDS:
        return words[:1]
    return () if list(words) == ["--version"] else COMMANDS


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command; every expected error is one line on stderr."""
    words = sys.argv[1:] if arguments is None else arguments
    before = os.umask(0o077)  # results show patients: whatever a command writes is for its user alone
    try:
        options = parser(_needed(words)).parse_args(words)
        interruption.work_begins()
        return int(options.run(options))
    except BreastRigError as error:
        print(f"breastrig: {error}", file=sys.stderr)
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
