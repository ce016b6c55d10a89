"""What `breastrig presets` does; its words stand in presets_options.py."""

import argparse

from breastrig.fitting.presets.preset_files import preset_names, preset_text


def run(options: argparse.Namespace) -> int:
    """Prints; returns 0."""
    print("\n".join(preset_names()) if options.action == "list" else preset_text(options.name), end="")
    if options.action == "list":
        print()
    return 0
