"""A scan with its colours, for whoever looks at them and shows them to nobody."""

from pathlib import Path

from breastrig.core.errors import TooLarge
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan


def coloured_scan(source: Path, file_type: str | None, units: str) -> Scan:
    """As `read_scan`; a scan whose picture alone is over a limit comes without colours."""
    try:
        return read_scan(source, file_type, units, for_display=False)
    except TooLarge:
        return read_scan(source, file_type, units, texture=False)
