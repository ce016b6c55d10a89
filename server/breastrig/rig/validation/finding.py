"""The result of one check of the rig."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Finding:
    """The result of one rule."""

    name: str  # of the rule, for instance "skin weights sum to 1"
    ok: bool
    detail: str  # what was found: numbers when it is kept, what is wrong and where when it is not
    severity: Literal["error", "advice"] = "error"  # a rig that only misses advice can still be fitted


def named(names: list[str], limit: int = 5) -> str:
    """The names that break a rule, as text for people."""
    return ", ".join(names[:limit]) + (f" and {len(names) - limit} more" if len(names) > limit else "")
