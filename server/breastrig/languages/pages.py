"""Typst pages in another language: the words that a template asks for with t("word"), and what a program puts there."""

import json
import re
from collections.abc import Mapping
from typing import Any

from breastrig.languages.catalogue import ENGLISH
from breastrig.languages.translation import document_said, said

ASKED = re.compile(r't\("([^"]+)"\)')


def page_data(template: bytes, content: Mapping[str, Any], language: str) -> str:
    """The data of a template as JSON: all texts of `content` in the language but those that are Typed."""
    words = {word: said(word, language) for word in ASKED.findall(template.decode())}
    shown = content if language == ENGLISH else document_said(content, language, lambda _holder, _name: True)
    return json.dumps({**shown, "words": words, "language": language}, allow_nan=False)
