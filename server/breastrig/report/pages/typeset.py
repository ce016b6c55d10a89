"""Sets a page: a Typst template of this package with its data.

The words that a template asks for with t("word"), and all texts that are not Typed, are in the language asked for.
"""

import json
import re
from collections.abc import Mapping
from importlib import resources
from typing import Any

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.languages.catalogue import ENGLISH
from breastrig.languages.translation import document_said, said
from breastrig.report.pages.printable import installed_fonts

ASKED = re.compile(r't\("([^"]+)"\)')


def typeset(folder: str, name: str, content: Mapping[str, Any], language: str = ENGLISH, **form: Any) -> Any:
    """The PDF, always the same bytes for the same content; or with `form` what else Typst makes.

    folder: of the template, in breastrig.report.
    """
    import typst  # takes 20 MB

    template = resources.files("breastrig.report").joinpath(folder, name).read_bytes()
    whole = {**content, "limits": LIMITS_OF_USE, "program": f"BreastRig {__version__}"}
    if language != ENGLISH:
        whole = document_said(whole, language, lambda _holder, _name: True)
    words = {word: said(word, language) for word in ASKED.findall(template.decode())}
    data = {"data": json.dumps({**whole, "words": words, "language": language}, allow_nan=False)}
    return typst.compile(template, sys_inputs=data, ignore_system_fonts=True, font_paths=installed_fonts(), **form)
