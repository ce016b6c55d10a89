"""Whose a document is: a code and never a name, the dates of scan and plan, and file names made of them."""

import re
import secrets
import unicodedata
from dataclasses import dataclass
from datetime import datetime

from breastrig.core.errors import BadInput

LETTERS = "ACDEFHJKLMNPQRTVWXY3479"  # none is taken for another: no B and 8, G and 6, I and 1, O and 0, S and 5, U, Z
NAMED = re.compile(r"[^A-Za-z0-9]+")
CODE_CHARACTERS = 60
HIDDEN = ("Cf", "Zl", "Zp", "Cs", "Co", "Cn")  # format (zero width, order of writing), lone separators, no characters
SAYS_NOTHING = (
    "what changes between two patients says nothing; check that both scans are of one, and file them under one code."
)


def random_code() -> str:
    """Six letters and digits, as K7M-4QX: one of 150 million, made of nothing of the patient."""
    letters = "".join(secrets.choice(LETTERS) for _ in range(6))
    return f"{letters[:3]}-{letters[3:]}"


def code_key(code: str) -> str:
    """Sort key of a code: numbers in it by their value, codes without a number last."""
    if code == "":
        return "1"
    return "0" + re.sub(r"[0-9]+", lambda found: f"{len(found[0].lstrip('0')):02}{found[0].lstrip('0')}", code.lower())


@dataclass(frozen=True)
class Identity:
    """The identity lines on every page of a report."""

    code: str = ""  # empty: not known
    made: datetime | None = None  # of the report; None: not said
    scanned: tuple[str, ...] = ()  # day of each stance's scan, ISO 8601; empty: not known
    received: bool = False  # the days are those on which the scans were given to the service
    planned: str = ""  # day of the plan's last change, ISO 8601; empty: not known
    plan_version: int = 0  # 0: not known, or no plan

    @property
    def day(self) -> str:
        """The day for file names: of the first scan, else of the report itself."""
        first = next((day for day in self.scanned if day), "")
        return first or ("" if self.made is None else self.made.date().isoformat())


INVISIBLE = "\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\uffa0"  # drawn as nothing, and no format characters by Unicode


def one_line(code: str) -> str:
    """A code as stored: composed letters, single blanks. BadInput for invisible or reordering characters."""
    hidden = [each for each in code if unicodedata.category(each) in HIDDEN or each in INVISIBLE]
    if hidden:
        named = ", ".join(dict.fromkeys(f"U+{ord(each):04X}" for each in hidden))
        raise BadInput(f"A patient's code cannot hold characters that nobody sees ({named}); leave them out.")
    return " ".join(unicodedata.normalize("NFC", code).split())


UNNAMED = Identity()  # nothing is known


def file_name(code: str, stances: str, day: str, what: str) -> str:
    """CODE_standing_2026-11-25_report.pdf, of characters that every file system and HTTP header takes."""
    parts = (plain(code) or "no-code", plain(stances), day)
    return "_".join([*(part for part in parts if part), what])


def plain(text: str) -> str:
    """Letters, digits and single hyphens; accents are dropped."""
    ascii_text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return NAMED.sub("-", ascii_text).strip("-")[:CODE_CHARACTERS]
