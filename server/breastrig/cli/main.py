"""`breastrig` and its commands.  Exit codes: 0 done, 1 the fit failed, 2 bad input or usage."""

import argparse
import sys
from collections.abc import Sequence

from breastrig import __version__
from breastrig.cli import (
    batch_command,
    compare_command,
    config_command,
    evaluate_command,
    export_command,
    fit_command,
    landmarks_command,
    model_command,
    purge_command,
    report_command,
    serve_command,
    transfer_command,
    worker_command,
)
from breastrig.core.errors import BadInput, BreastRigError
from breastrig.core.notice import LIMITS_OF_USE, RESEARCH_USE_ONLY


def parser() -> argparse.ArgumentParser:
    root = argparse.ArgumentParser(
        prog="breastrig",
        description="Fits a rigged torso model to a 3D scan and lays surgical drawings on it.",
        epilog=LIMITS_OF_USE,
    )
    root.add_argument("--version", action="version", version=f"BreastRig {__version__}. {RESEARCH_USE_ONLY}")
    commands = root.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in (
        fit_command,
        transfer_command,
        compare_command,
        report_command,
        export_command,
        landmarks_command,
        batch_command,
        evaluate_command,
        model_command,
        serve_command,
        worker_command,
        config_command,
        purge_command,
    ):
        module.add_parser(commands)
    return root


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command; every expected error is one line on stderr."""
    options = parser().parse_args(arguments)
    try:
        return int(options.run(options))
    except BreastRigError as error:
        print(f"breastrig: {error}", file=sys.stderr)
        return 2 if isinstance(error, BadInput) else 1
    except BrokenPipeError:
        return 1
    except KeyboardInterrupt:
        print("breastrig: stopped.", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
