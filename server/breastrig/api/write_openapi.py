"""`python -m breastrig.api.write_openapi` writes the committed openapi.json, from which the page's types are made."""

import json
from pathlib import Path

from breastrig.api.app import openapi_document

FILE = Path(__file__).with_name("openapi.json")


def openapi_text() -> str:
    """The document as it is committed."""
    return json.dumps(openapi_document(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    FILE.write_text(openapi_text(), encoding="utf-8")
