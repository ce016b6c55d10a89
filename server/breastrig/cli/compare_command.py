"""What `breastrig compare` does; its words stand in compare_options.py."""

import argparse
import sys
from pathlib import Path

from breastrig.cli.output_options import files_of_fit, files_of_model, output_folder
from breastrig.core.output_files import OutputSet, all_or_nothing
from breastrig.workflow.lines.compare import COMPARE_FILES, COMPARE_RECORD, SCHEMA, CompareJob, compare


def run(options: argparse.Namespace) -> int:
    """Measures, draws and writes; returns 0."""
    inputs = [options.first, options.second, *files_of_fit(options.fit), *files_of_model(options.model)]
    files = OutputSet(Path(), COMPARE_FILES, COMPARE_RECORD, SCHEMA)
    with all_or_nothing(output_folder(options, [files], inputs)) as out:
        document = compare(CompareJob(options.fit, options.first, options.second, out, options.model))
    if sys.stdout.isatty():
        for row in document["distances"]:
            print(f"{row['shape']}: mean {row['mean_mm']:.2f}, 95 % {row['p95_mm']:.2f}, max {row['max_mm']:.2f} mm")
    return 0
