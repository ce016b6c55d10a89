"""The files of a case, and the folders around it.

    CASE/case.json               the patient's code
    CASE/plan.json               what is planned; plans/000007.json: earlier versions
    CASE/.lock                   held by whoever writes
    CASE/.new                    its first scan is on the way from another case
    CASE/scans/S/                scan.json, scan.stored, mesh.glb, thumbnail.png, volume.npz (of an image),
                                 landmarks.json, length.json, cuts.json, ink.json, proposals.json, answers.json,
                                 expires.json
    CASE/scans/S/fits/F/         fit.json, fit.log.jsonl (line N is event N), .claim, .attempts, cancel, and what
                                 `breastrig fit` writes
    .../fits/F/links/L/          link.json, shown-N/

A case of a data folder is in `data/cases/`; what is on its way in or out is in `data/incoming/` and
`data/rubbish/`.  A case that stands alone has both inside itself.
"""

import os
import re
import secrets
from dataclasses import dataclass
from pathlib import Path

from breastrig.core.errors import NotFound

CASES, RUBBISH, INCOMING = "cases", "rubbish", "incoming"
MARK = "installation"  # says that a folder is a data folder of BreastRig
CASE, PLAN, PLANS, NEW = "case.json", "plan.json", "plans", ".new"
SCANS, SCAN, STORED, MESH, THUMBNAIL = "scans", "scan.json", "scan.stored", "mesh.glb", "thumbnail.png"
VOLUME = "volume.npz"
LANDMARKS, CUTS, INK, PROPOSALS = "landmarks.json", "cuts.json", "ink.json", "proposals.json"
ANSWERS, EXPIRES = "answers.json", "expires.json"
FITS, FIT, LOG, CLAIM, ATTEMPTS, CANCEL = "fits", "fit.json", "fit.log.jsonl", ".claim", ".attempts", "cancel"
LINKS, LINK, SHOWN = "links", "link.json", "shown-"
ID = re.compile(r"[A-Za-z0-9_-]{22}")


def new_id() -> str:
    """128 random bits as 22 URL-safe characters; never an option of a command line."""
    while True:
        found = secrets.token_urlsafe(16)
        if found[0] != "-":
            return found


@dataclass(frozen=True)
class Surroundings:
    """The folders around one case."""

    rubbish: Path
    incoming: Path
    name: str  # of the case there

    def away(self, scan_id: str) -> Path:
        """A folder: the scan is deleted, and what is left of it is to be removed.  A file: it is being moved."""
        return self.rubbish / f"{self.name}.{scan_id}"

    def marks(self) -> dict[str, bool]:
        """{scan that is deleted or being moved: whether it is deleted}"""
        try:
            with os.scandir(self.rubbish) as entries:
                found = {entry.name: entry.is_dir(follow_symlinks=False) for entry in entries}
        except FileNotFoundError:
            return {}
        before = f"{self.name}."
        named = {name.removeprefix(before): deleted for name, deleted in found.items() if name.startswith(before)}
        return {scan: deleted for scan, deleted in named.items() if ID.fullmatch(scan)}


def data_folder_of(case: Path) -> Path | None:
    """The data folder that a case is in; None: it stands alone."""
    root = case.parent.parent
    return root if case.parent.name == CASES and (root / MARK).is_file() else None


def surroundings_of(case: Path) -> Surroundings:
    """The folders for what comes into a case or leaves it."""
    root = data_folder_of(case)
    if root is not None:
        return Surroundings(root / RUBBISH, root / INCOMING, case.name)
    return Surroundings(case / ".rubbish", case / ".incoming", "case")


def scan_part(scan_id: str) -> str:
    """The scan's folder inside the case.  Raises NotFound for what can be no scan's id."""
    return f"{SCANS}/{_checked(scan_id, 'scan')}"


def fit_part(scan_id: str, fit_id: str) -> str:
    """The fit's folder inside the case.  Raises NotFound."""
    return f"{scan_part(scan_id)}/{FITS}/{_checked(fit_id, 'fit')}"


def link_part(scan_id: str, fit_id: str, link_id: str) -> str:
    """The link's folder inside the case.  Raises NotFound."""
    return f"{fit_part(scan_id, fit_id)}/{LINKS}/{_checked(link_id, 'link')}"


def _checked(name: str, kind: str) -> str:
    if not ID.fullmatch(name):
        raise NotFound(f"There is no such {kind}; it may have been deleted.")
    return name
