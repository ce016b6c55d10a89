"""The test set: measured at most once for each commit, by a command that records it in a log.

breastrig evaluate COHORT --test docs/test_set.md -o DIR
"""

import subprocess
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from breastrig import __version__
from breastrig.core.errors import BadInput
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.trust.asked import RIGHT

TITLE = """# Test set

Virtual patients on whom nothing is chosen.  Only `breastrig evaluate COHORT --test docs/test_set.md` reads them, and
appends a line.  Scans are whole and without tables, the stance is `auto`; a fit is right when its landmarks are no more
than 15 mm off on average.  *good*: of right fits with all landmarks.  *wrong*: called good, of fits that are not right,
with one landmark 30 mm off, or of scans 1.25 times too large without a question about the patient's size.
*stance*: right, and how many others are said to be unclear.  *mm*: landmarks, all and none given.

"""
ASKED = "The trunk is"  # begins a question about the patient's size
COLUMNS = (
    "date",
    "commit",
    "release",
    "cohort",
    "women",
    "scans",
    "good",
    "wrong",
    "stance, all given",
    "none given",
    "mm",
)


def commit() -> str:
    """The commit of the work tree of this code, marked when it was changed since; BadInput without one."""
    asked = ["git", "describe", "--always", "--dirty=+", "--exclude=*"]
    try:
        found = subprocess.run(asked, cwd=Path(__file__).parent, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise BadInput("--test says which commit looked, so that it runs from a git checkout only.") from error
    return found.stdout.strip()


def check_unseen(log: Path, code: str, again: bool) -> None:
    """Raises BadInput when this commit has been measured already."""
    if log.is_file() and f"| {code} |" in log.read_text("utf-8") and not again:
        raise BadInput(f"The test set was looked at with {code} already, see {log.name}; --again looks once more.")


def log_line(log: Path, code: str, cohort: str, records: Sequence[Record]) -> str:
    """The line that it appends to the log, which it begins where there is none."""
    line = _row([f"{datetime.now(UTC):%Y-%m-%d}", code, __version__, cohort, *figures(records)])
    head = "" if log.is_file() else TITLE + _row(COLUMNS) + _row(["---"] * len(COLUMNS))
    with log.open("a", encoding="utf-8") as file:
        file.write(head + line)
    return line.rstrip()


def figures(records: Sequence[Record]) -> list[str]:
    """The log's columns after the cohort."""
    done = [record for record in records if record.unit.question == "asked" and not record.failed]

    def is_right(fit: dict[str, object]) -> bool:
        return float(str(fit.get("error_mm", np.inf))) <= RIGHT

    given = [record.answer["all"] for record in done if is_right(record.answer["all"])]
    wrong = [fit for r in done for k, fit in r.answer.items() if k in ("one_wrong", "larger") or not is_right(fit)]
    columns = [str(len({record.case.patient for record in done})), str(len(done))]
    columns += [_share([fit["level"] == "good" for fit in given])]
    columns += [_share([fit["level"] == "good" and ASKED not in " ".join(fit["reasons"]) for fit in wrong])]
    for kind in ("all", "none"):
        found = [(record.answer[kind], record.case.stance) for record in done if "stance" in record.answer[kind]]
        missed = [fit["unclear"] for fit, true in found if fit["stance"] != true]
        columns.append(f"{_share([fit['stance'] == true for fit, true in found])}, {sum(missed)} of {len(missed)}")
    errors = [[r.answer[kind]["error_mm"] for r in done if "error_mm" in r.answer[kind]] for kind in ("all", "none")]
    return [*columns, " / ".join(f"{np.mean(each):.1f}" for each in errors if each)]


def _share(each: Sequence[bool]) -> str:
    return f"{100.0 * np.mean(each):.0f} % of {len(each)}" if len(each) else "none"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |\n"
