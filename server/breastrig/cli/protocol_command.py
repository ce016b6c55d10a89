"""A printed page for taking scans with marks: the dots, the arms, one length, the order of the scans."""

import argparse
from pathlib import Path

from breastrig.cli.options.output_options import add_language, writing_file
from breastrig.use.reports.report import protocol_pdf_of


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="the PDF, one A4 page")
    add_language(parser)
    parser.add_argument("--force", action="store_true", help="replace a file")


def run(options: argparse.Namespace) -> int:
    """Writes the page; returns 0."""
    with writing_file(options) as write:
        write(protocol_pdf_of(options.language))
    return 0
