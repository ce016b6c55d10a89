"""The commands and what each of them is for, in one line; nothing else is needed to list them.

Other packages add commands by the entry points `breastrig.commands`: modules with a docstring, add_options and run.
"""

import importlib
from typing import Any

from breastrig.core.errors import BadInput

GROUP = "breastrig.commands"

COMMANDS = {
    "fit": "fit the model to one scan",
    "transfer": "show a drawing of one scan on another",
    "predict": "show the patient of a scan in another stance",
    "compare": "superimpose two drawings of one scan",
    "report": "measures and pictures of one or two fits",
    "template": "the plan in true size on paper, to lay on the skin",
    "protocol": "a page to print for taking scans with marks",
    "export": "drawing and closed surface for other programs",
    "dicom": "a fit as DICOM objects, for a hospital's archive",
    "volume": "tetrahedra of the fitted body for finite elements",
    "landmarks": "propose the landmarks on one scan",
    "ink": "find lines that were drawn on the skin of one scan",
    "marks": "propose the marks that two coloured scans share",
    "batch": "fit the model to many scans",
    "visits": "what changed between the visits of one patient",
    "case": "a patient's folder: scans, fits, plan and its versions",
    "cohort": "learn a prior from a clinic's fits, merge, share",
    "presets": "list the presets of fits, or show one",
    "model": "describe, check or build the model",
    "serve": "serve the page and the HTTP API",
    "worker": "run fits for a Dask scheduler",
    "config": "show the settings of the service",
    "index": "make the index of a data folder's cases again",
    "audit": "who opened, changed, exported or deleted what; its check",
    "backup": "a data folder in one encrypted file, also while it is served",
    "restore": "a backup into a new data folder",
    "purge": "delete stored scans and all that was made of them",
}

OF_THE_SERVER = ("serve", "config", "purge")  # they need the extra `server`
OF_UNIX = (
    *OF_THE_SERVER,
    "backup",
    "batch",
    "index",
    "restore",
    "worker",
)  # processes with limits, and locks of folders


def own_module(command: str) -> Any:
    """`breastrig.cli.COMMAND_command`; BadInput when a package that it needs is missing."""
    try:
        if command in OF_UNIX:
            importlib.import_module("fcntl")
        return importlib.import_module(f"breastrig.cli.{command}_command")
    except ModuleNotFoundError as error:
        if error.name in ("fcntl", "resource"):
            raise BadInput(
                f"`breastrig {command}` needs Linux or macOS; fits, reports and the library work here as well."
            ) from error
        if command in ("backup", "restore") and (error.name or "").startswith("cryptography"):
            raise BadInput(f'`breastrig {command}` needs cryptography: pip install "breastrig[backup]".') from error
        if command not in OF_THE_SERVER or (error.name or "").startswith("breastrig"):
            raise
        raise BadInput(f'`breastrig {command}` needs the server: pip install "breastrig[server]".') from error


def further_commands() -> dict[str, str]:
    """The commands of other installed packages, with a description of each."""
    from importlib.metadata import entry_points  # half of the time of `breastrig --version`, which asks for none

    return {each.name: f"of the package {each.module.partition('.')[0]}" for each in entry_points(group=GROUP)}


def further_module(command: str) -> Any:
    """The module of another package's command; BadInput when that package cannot be imported."""
    from importlib.metadata import entry_points

    entry = next(iter(entry_points(group=GROUP, name=command)))
    try:
        return entry.load()
    except ModuleNotFoundError as error:
        raise BadInput(
            f"`breastrig {command}` needs {error.name}, which is not installed: see server/ in its repository."
        ) from error
