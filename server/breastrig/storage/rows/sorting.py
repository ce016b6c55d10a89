"""What codes are sorted by, on every database the same: numbers in them by their value, patients without one last."""

import re


def code_key(code: str) -> str:
    """A text whose order is that of the codes: "ward 9" comes before "Ward 10", and no code after all."""
    if code == "":
        return "1"
    return "0" + re.sub(r"[0-9]+", lambda found: f"{len(found[0].lstrip('0')):02}{found[0].lstrip('0')}", code.lower())
