"""`python -m breastrig.api.write_openapi` writes the committed openapi.json, from which the page's types are made."""

from pathlib import Path

from breastrig.api.app import openapi_document
from breastrig.api.openapi import openapi_bytes

FILE = Path(__file__).with_name("openapi.json")

if __name__ == "__main__":
    FILE.write_bytes(openapi_bytes(openapi_document()))
