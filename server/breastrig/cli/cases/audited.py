"""Lines in the audit log for `breastrig case`, where it works on a data folder."""

import argparse
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from breastrig.audit.log import AuditLog, Entry, log_of_case
from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cli.messages.say import say
from breastrig.core.errors import BadInput, NotFound

OPENS = ("show", "list")
WRITES_ITSELF = ("delete",)


def shell() -> str:
    """Who uses the command line."""
    return f"shell:{os.getuid()}" if hasattr(os, "getuid") else "shell"


@contextmanager
def audited(options: argparse.Namespace) -> Iterator[None]:
    """Writes what the action is about to do, and afterwards what it has made (`options.made`).

    Raises BadInput where that cannot be written: then nothing may be changed.
    """
    if options.action in WRITES_ITSELF:
        yield
        return
    opens = options.action in OPENS or getattr(options, "output", None) is not None
    kind = ("export" if options.action == "plan" else "open") if opens else "change"
    logs = [log for path in (options.case, getattr(options, "target", None)) if path and (log := _log(path))]
    how, of = f"case {options.action}", _of(options)
    lines = {}
    for log in {log.root: log for log in logs}.values():
        try:
            lines[log] = log.append(Entry(shell(), kind, how, of))[-1].line
        except OSError as error:
            if not opens:
                raise BadInput(
                    f"The audit log of {log.root} cannot be written ({error.strerror}), so nothing was changed; mend "
                    "that first."
                ) from error
            say(f"the audit log cannot be written ({error.strerror})")
    yield
    made = getattr(options, "made", {})
    for log, line in lines.items():
        if made:
            log.later(Entry(shell(), "done", how, made, {"line": line}))
            log.flush()


def _log(path: Path) -> AuditLog | None:
    return AuditLog(path) if (path / layout.MARK).is_file() else log_of_case(path)


def _of(options: argparse.Namespace) -> dict[str, str]:
    named = {"patient": options.case.absolute(), "to_patient": getattr(options, "target", Path()).absolute()}
    of = {kind: path.name for kind, path in named.items() if layout.data_folder_of(path) is not None}
    scan = getattr(options, "scan", "")
    if isinstance(scan, str) and scan.isdecimal():
        try:
            of |= {"scan": CaseFolder(options.case).scans()[int(scan) - 1].id}
        except (NotFound, IndexError):
            return of  # the action says so
    return of | ({"scan": scan} if isinstance(scan, str) and layout.ID.fullmatch(scan) else {})
