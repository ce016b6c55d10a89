"""The certificate of a deletion as PDF: what was removed, by whom, when, and what it does not cover."""

import json
from collections.abc import Sequence
from importlib import resources

import typst

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.report.pages.printable import installed_fonts

NOT_COVERED = (
    "Backups: they hold the data until they are themselves deleted. BreastRig restores no patient whose deletion it "
    "knows of unless it is asked to.",
    "Files that people have exported or printed, and what visitors of links have kept.",
    "Free space of the disk: deleted blocks are overwritten by other files in time, not by BreastRig.",
    "This audit log: it keeps the random ids and the times, and no code, name or content.",
)


def deletion_certificate_pdf(rows: Sequence[tuple[str, str]], said: Sequence[str]) -> bytes:
    """One A4 page: rows of a name and its value, then sentences on how it was verified."""
    template = resources.files("breastrig.report.certificates").joinpath("deletion.typ").read_bytes()
    content = {
        "title": "Certificate of deletion",
        "rows": list(rows),
        "said": list(said),
        "not_covered": NOT_COVERED,
        "limits": LIMITS_OF_USE,
        "program": f"BreastRig {__version__}",
    }
    data = {"data": json.dumps(content)}
    return bytes(typst.compile(template, sys_inputs=data, ignore_system_fonts=True, font_paths=installed_fonts()))
