"""`breastrig serve` with fits that need no numerics: run as a program by the tests of the real server."""

import argparse
import os
import sys

from breastrig.cli import serve_command
from helpers import fake_fit

if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    serve_command.add_parser(parser.add_subparsers())
    runner = getattr(fake_fit, os.environ.get("FAKE_FIT", "mostly_patient"))
    sys.exit(serve_command.serve(parser.parse_args(["serve", *sys.argv[1:]]), runner))
