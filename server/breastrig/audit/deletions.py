"""A deletion in the audit log: one line before it with what there is to delete, one after it with what is left."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

from breastrig.audit.log import AuditLog, Entry, Fields
from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.core.errors import NotFound

NAMED = 100  # scans by their ids; of more, the number


class Deletion:
    """One that has started, with a line of what is to be deleted: a scan, or the case, with the last scan as well.

    On a full disk the line waits; any other OSError is raised, and nothing may be deleted.
    """

    def __init__(
        self, log: AuditLog, who: str, how: str, of: Mapping[str, str], named: Fields = MappingProxyType({})
    ) -> None:
        self._log, self._who, self._how, self._of = log, who, how, of
        removes = _counts(log.root / layout.CASES / (of.get("patient") or "none"), of.get("scan", ""))
        self._line = log.append_deletion(Entry(who, "delete", how, of, {**named, "removes": removes}))

    def ended(self) -> None:
        """`done`, or `refused` where the scan or case is still there for all to see."""
        what = "refused" if is_there(self._log.root, self._of) else "done"
        said = {"left": left_of(self._log.root, self._of)} | ({} if self._line is None else {"line": self._line.line})
        entry = Entry(self._who, what, self._how, self._of, said)
        try:
            self._log.append_deletion(entry)
        except OSError:  # it is done, whatever can be written
            self._log.later(entry)


def is_there(root: Path, of: Mapping[str, str]) -> bool:
    """Whether a scan or case is there, and not deleted."""
    try:
        case = CaseFolder(root / layout.CASES / (of.get("patient") or "none"))
    except NotFound:
        return False
    return "scan" not in of or of["scan"] in case.scan_ids()


def left_of(root: Path, of: Mapping[str, str]) -> int:
    """The number of folders of a deleted scan or case that are still in the data folder."""
    patient, scan = of.get("patient", ""), of.get("scan", "")
    rubbish = root / layout.RUBBISH
    names = os.listdir(rubbish) if rubbish.is_dir() else []
    if scan:
        places = [root / layout.CASES / patient / layout.SCANS / scan, rubbish / patient / layout.SCANS / scan]
        return sum(name.endswith(f".{scan}") for name in names) + sum(place.exists() for place in places)
    return sum(name.partition(".")[0] == patient for name in names) + (root / layout.CASES / patient).exists()


@contextmanager
def deletion(log: AuditLog, who: str, how: str, case: Path, scan: str = "") -> Iterator[None]:
    """Writes a deletion that is done inside the block, and its end, also where files are left."""
    started = Deletion(log, who, how, {"patient": case.name} | ({"scan": scan} if scan else {}))
    try:
        yield
    finally:
        started.ended()


def _counts(path: Path, scan: str) -> dict[str, object]:
    try:
        case = CaseFolder(path)
        scans = sorted(case.scan_ids())
    except NotFound:
        return {}
    folder, whole = path, True
    if scan and scans != [scan]:
        folder, whole, scans = case.scan_folder(scan), False, [scan]
    files = total = fits = links = 0
    for place, folders, names in os.walk(folder):
        kind = os.path.basename(place)
        known = sum(layout.ID.fullmatch(each) is not None for each in folders)
        fits += known if kind == layout.FITS else 0
        links += known if kind == layout.LINKS else 0
        files += len(names)
        total += sum(os.lstat(os.path.join(place, name)).st_size for name in names)
    named: dict[str, object] = {"scan_ids": scans[:NAMED]}
    return {"case": whole, "scans": len(scans), "fits": fits, "links": links, "files": files, "bytes": total} | named
