"""Sets a page: a Typst template of this package with its data."""

from collections.abc import Mapping
from importlib import resources
from typing import Any

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.languages.catalogue import ENGLISH
from breastrig.languages.pages import page_data
from breastrig.report.pages.printable import installed_fonts


def typeset(folder: str, name: str, content: Mapping[str, Any], language: str = ENGLISH, **form: Any) -> Any:
    """The PDF, always the same bytes for the same content; or with `form` what else Typst makes.

    folder: of the template, in breastrig.report.
    """
    import typst  # takes 20 MB

    template = resources.files("breastrig.report").joinpath(folder, name).read_bytes()
    of_all = {"limits": LIMITS_OF_USE, "program": f"BreastRig {__version__}"}
    data = {"data": page_data(template, {**content, **of_all}, language)}
    return typst.compile(template, sys_inputs=data, ignore_system_fonts=True, font_paths=installed_fonts(), **form)
