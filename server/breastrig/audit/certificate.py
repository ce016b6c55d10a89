"""The certificate of a deletion: what was removed, by whom, when, as log and folder say, and what it does not cover."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breastrig.audit.deletions import left_of
from breastrig.audit.read import check, deletions, lines_from
from breastrig.cases.case_folder import utc_now
from breastrig.core.errors import Conflict, NotFound
from breastrig.languages.catalogue import ENGLISH
from breastrig.languages.translation import Typed
from breastrig.report.pages.typeset import typeset

NONE = "The audit log has no deletion of this id; give the id of a patient or scan that was deleted."


@dataclass(frozen=True)
class Certificate:
    """All that the page says, and who asked for the deletion."""

    rows: tuple[tuple[str, str], ...]
    said: tuple[str, ...]
    who: str

    def pdf(self, language: str = ENGLISH) -> bytes:
        """One A4 page."""
        return bytes(typeset("pages", "deletion.typ", {"rows": self.rows, "said": self.said}, language))


def certificate(root: Path, of: str) -> Certificate:
    """Of the newest deletion of a patient or scan.

    Raises NotFound where none is in the log, Conflict where something of it is still there.
    """
    asked = next((line for line in deletions(root, of) if _is_of(line, of)), None)
    if asked is None:
        raise NotFound(NONE)
    ids, removes = asked["of"], asked["removes"]
    gone = {"patient": ids["patient"]} if removes["case"] else ids
    if left_of(root, gone):
        raise Conflict(
            "The deletion is not complete: files are left; the service goes on trying, and its log says why."
        )
    done, checked = asked["done"], check(root)
    exports = [line for line in lines_from(root, of, before=asked["n"]) if line["what"] == "export"]
    who = f"{asked['name']} ({asked['who']})" if "name" in asked else asked["who"]
    scans, fits, links, files = (removes[each] for each in ("scans", "fits", "links", "files"))
    megabytes = removes["bytes"] / 1e6
    rows = (
        ("Patient (random id)", ids["patient"] if removes["case"] else f"{ids['patient']}, whose other scans are kept"),
        ("Scans (random ids)", ", ".join(removes["scan_ids"]) or "none"),
        (
            "Removed",
            f"scans: {scans}, fits: {fits}, links: {links}, files: {files} "
            f"({megabytes:.1f} MB), and what was planned on these scans",
        ),
        ("Asked for", f"{asked['at']} (UTC)"),
        ("Asked by", Typed(f"{who}, {asked.get('how', '')}")),
        ("Done", "its end was not recorded" if done is None else f"{done['at']} (UTC)"),
        ("Line of the audit log", f"{asked['n']}, SHA-256 {asked['sha256']}"),
        ("Line of its end", "none" if done is None else f"{done['n']}, SHA-256 {done['sha256']}"),
        ("Exports recorded before", str(len(exports))),
        ("Issued", f"{utc_now()} (UTC)"),
    )
    log = (
        checked.fault or f"The {checked.lines} lines of the audit log are as they were written, to line {checked.end}."
    )
    said = ("When this page was issued, no folder of these ids was in the data folder.", log)
    return Certificate(rows, said, asked["who"])


def _is_of(line: dict[str, Any], of: str) -> bool:
    removes = line["removes"]
    return bool(line["of"].get("patient") == of and removes["case"]) or of in removes["scan_ids"]
