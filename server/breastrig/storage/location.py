"""Where rows and files are: all that a worker on another machine has to be told."""

from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Location:
    """Everything below `root`, unless an address says otherwise."""

    root: Path  # on this machine
    database: str | None = field(default=None, repr=False)  # postgresql://...; it may hold a password
    files: str | None = None  # s3://bucket/prefix or another URL that fsspec knows
