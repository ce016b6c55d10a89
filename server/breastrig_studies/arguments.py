"""The command line of a study that is run as a program: python -m breastrig_studies.NAME."""

from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter


def arguments(description: str | None, *wanted: str) -> Namespace:
    """What was given, by name in small letters; exits with one line where it does not fit.

    wanted: "DATA" is one text, "[DATA]" one or none (None), "DATA..." one or more, "--write" a flag.
    """
    parser = ArgumentParser(description=description, formatter_class=RawDescriptionHelpFormatter)
    for each in wanted:
        if each.startswith("--"):
            parser.add_argument(each, action="store_true")
            continue
        name = each.strip("[].")
        nargs = "+" if each.endswith("...") else "?" if each.startswith("[") else None
        parser.add_argument(name.lower(), metavar=name, nargs=nargs)
    return parser.parse_args()
