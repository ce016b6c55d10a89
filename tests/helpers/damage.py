"""Random damage to files, for tests that feed readers with it.

Each test says a number of cases.  `make test` tries a tenth of them, the same ones each time; `make fuzz`
BREASTRIG_FUZZ times as many, other ones each time.
"""

import os

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

TIMES = float(os.environ.get("BREASTRIG_FUZZ", "0.1"))


def bounded(examples: int) -> settings:
    """TIMES so many cases, at least one."""
    return settings(
        max_examples=max(1, round(examples * TIMES)),
        derandomize=TIMES < 1,
        deadline=None,
        database=None,
        print_blob=True,
        suppress_health_check=list(HealthCheck),
    )


BOUNDED = bounded(150)
Edits = list[tuple[str, int, bytes]]


@st.composite
def damage(draw: st.DrawFn, length: int, header: int = 600) -> Edits:
    """A few edits for a file of `length` bytes, more of them near the beginning, where headers are."""
    near = st.integers(0, min(length - 1, header))
    place = st.one_of(near, near, st.integers(0, length - 1))
    edit = st.tuples(st.sampled_from(["set", "set", "insert", "cut", "end"]), place, st.binary(min_size=1, max_size=6))
    return draw(st.lists(edit, min_size=1, max_size=6))


def damaged(data: bytes, edits: Edits) -> bytes:
    """The file after the edits."""
    for what, place, content in edits:
        if what == "set":
            data = data[:place] + content + data[place + len(content) :]
        elif what == "insert":
            data = data[:place] + content + data[place:]
        elif what == "cut":
            data = data[:place] + data[place + len(content) :]
        else:
            data = data[: place + 1]
    return data
