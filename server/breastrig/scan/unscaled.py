"""Files that do not say how large the patient is: of programs without a scale, or with no unit where one has a place.

Of a file its comments, or the name of its generator, are compared; nothing of them is kept.
"""

import re
from collections.abc import Iterable
from functools import lru_cache

from breastrig.core.settings_file import Positive, SettingsPart, packaged

LOOKED_AT = 4096  # bytes at the beginning
COMMENTS = {"ply": re.compile(r"(?m)^(?:comment|obj_info) +(.*)$"), "obj": re.compile(r"(?m)^#+ *(.*)$")}
UNKNOWN_SIZE = (
    "The size of this scan is not known: its file is of an app without a scale, or names no unit; measure a straight "
    "length on the patient, and give it as the true size."
)
NO_SCALE = "Its app has no scale: scale the scan there, by a length measured on the patient."


class Program(SettingsPart):
    says: str
    source: str  # where it is seen that it says so, and that its size is nobody's


class Unscaled(SettingsPart):
    deviation: Positive  # standard deviation of such a size, as a share
    programs: tuple[Program, ...]


@lru_cache(maxsize=1)
def unscaled() -> Unscaled:
    """The programs, and how far off their sizes are."""
    return packaged(Unscaled, "breastrig.scan", "unscaled.toml")


def names_unscaled(said: Iterable[object]) -> bool:
    """Whether one of these texts is of a program without a scale."""
    begin = tuple(each.says for each in unscaled().programs)
    return any(isinstance(each, str) and each.strip().startswith(begin) for each in said)


def comments(data: bytes, kind: str) -> list[str]:
    """The comments at the beginning of a PLY or OBJ file; none of other kinds."""
    if kind not in COMMENTS:
        return []
    head = data[:LOOKED_AT].partition(b"end_header")[0].replace(b"\r", b"\n")
    return COMMENTS[kind].findall(head.decode("latin-1"))
