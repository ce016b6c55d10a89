"""Reads the audit log: its lines, one page or all, and whether they are what was written."""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breastrig.audit.log import FOLDER, Mark, installation_of, log_files, noted_end, number_of
from breastrig.core.errors import BadInput

NOT_A_MARK = "An anchor is the number of a line, a colon and the 64 digits of its SHA-256, as `audit check` prints it."


@dataclass(frozen=True)
class Checked:
    """What a check has found."""

    lines: int
    end: Mark  # of the last line, to be noted elsewhere
    fault: str = ""  # one sentence on the first line that is not as it was written; empty: none


def lines_from(root: Path, of: str = "", since: str = "", before: int | None = None) -> Iterator[dict[str, Any]]:
    """The lines, newest first: those that name an id, not older than a time (ISO 8601, UTC), below a number.

    Raises BadInput for a line that is none.
    """
    wanted = f'"{of}"'.encode() if of else b""
    for file in reversed(log_files(root / FOLDER)):
        if before is not None and int(file.stem) >= before:
            continue
        for content in reversed(file.read_bytes().split(b"\n")[:-1]):  # half a line counts when it is whole
            if wanted not in content:
                continue
            try:
                number = number_of(content)
                line = json.loads(content) if before is None or number < before else {}
            except ValueError as error:
                said = f"{file.name} of the audit log has a damaged line; `breastrig audit check` says which."
                raise BadInput(said) from error
            if line and str(line.get("at", "")) >= since:
                yield line | {"sha256": hashlib.sha256(content).hexdigest()}


def deletions(root: Path, of: str = "") -> Iterator[dict[str, Any]]:
    """The lines of deletions that were not refused, newest first; `done`: the line of its end, where there is one."""
    ends: dict[int, dict[str, Any]] = {}
    for line in lines_from(root, of):
        if line["what"] in ("done", "refused"):
            ends[line.get("line", 0)] = line
        elif line["what"] == "delete" and line.get("removes") and ends.get(line["n"], {}).get("what") != "refused":
            yield line | {"done": ends.get(line["n"])}


def check(root: Path, anchor: Mark | None = None) -> Checked:
    """Follows the chain through all lines to the end that was noted, and to an anchor that was noted elsewhere.

    Who may write into the folder may write a whole new chain: only an anchor kept elsewhere shows that.
    """
    folder = root / FOLDER
    noted, last, fault, seen = noted_end(folder), Mark(), "", set[Mark]()
    for file in log_files(folder):
        if int(file.stem) != last.line + 1:
            return Checked(last.line, last, _missing(last.line + 1, int(file.stem) - 1))
        for content in file.read_bytes().split(b"\n")[:-1]:
            fault = _fault(content, last, file)
            if fault:
                return Checked(last.line, last, fault)
            last = Mark(last.line + 1, hashlib.sha256(content).hexdigest())
            if last.line == 1 and json.loads(content).get("installation") != installation_of(root):
                return Checked(1, last, "Line 1 names another data folder: this is the log of that one.")
            if last in (noted, anchor):
                seen.add(last)
    for mark, where in ((noted, f"{FOLDER}/end notes"), (anchor or Mark(), "the anchor says")):
        if mark.line > last.line:
            return Checked(last.line, last, _missing(last.line + 1, mark.line))
        if mark.line and mark not in seen:
            return Checked(last.line, last, f"Line {mark.line} is not the one that {where}: the log was written anew.")
    return Checked(last.line, last)


def read_mark(text: str) -> Mark:
    """NUMBER:SHA256. Raises BadInput."""
    number, _, sha256 = text.strip().partition(":")
    if not (number.isascii() and number.isdigit() and len(sha256) == 64 and set(sha256) <= set("0123456789abcdef")):
        raise BadInput(NOT_A_MARK)
    return Mark(int(number), sha256)


def _fault(content: bytes, last: Mark, file: Path) -> str:
    number = last.line + 1
    if content.startswith(f'{{"n":{number},"before":"{last.sha256}",'.encode()):
        return ""
    try:
        found = number_of(content)
        before = json.loads(content)["before"]
    except (ValueError, KeyError, TypeError):
        return f"Line {number} (in {file.name}) is damaged."
    if found != number:
        return _missing(number, found - 1) if found > number else f"Line {found} is in the place of line {number}."
    if before != last.sha256 and number == 1:
        return "Line 1 follows another line, which is missing."
    return f"Line {last.line} was changed: line {number} names another one as the line before it."


def _missing(first: int, last: int) -> str:
    return f"Line {first} is missing." if first == last else f"Lines {first} to {last} are missing."
