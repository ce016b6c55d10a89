"""Finds characters that the report's fonts cannot print, by asking the typesetter; it would print boxes for them.

The fonts are those that Typst ships (Latin, Greek, Cyrillic, Hebrew, Arabic, Armenian, Georgian, Devanagari) and, where
`breastrig[fonts]` is installed, Noto for Chinese, Japanese, Korean, Thai, Lao, Khmer and Myanmar.
"""

import re
import unicodedata
from collections.abc import Iterable
from functools import cache, lru_cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from breastrig.core.errors import BadInput
from breastrig.core.identity import one_line

if TYPE_CHECKING:
    import typst

PACKS = ("justmytype_intl_cjk", "justmytype_intl_sea")  # breastrig[fonts]
ALWAYS = re.compile(r"[\s\x20-\x7e\xa1-\xac\xae-\u017f]*")  # without asking: the typesetter takes 20 MB
NO_CHARACTER = "\U0010fffe"  # no font has it: drawn as the box that stands for all that is missing
GLYPH = re.compile(r'xlink:href="#(\w+)"')
NAMED_CHARACTERS = 12  # in a sentence


def installed_fonts() -> "typst.Fonts":
    """The fonts of `font_folders` and the typesetter's own."""
    import typst

    return typst.Fonts(include_system_fonts=False, font_paths=list(font_folders()))


@cache
def font_folders() -> list[Path]:
    """The folders of installed fonts beside the typesetter's own."""
    packs = [Path(str(files(name) / "fonts")) for name in PACKS if find_spec(name) is not None]
    return sorted({font.parent for pack in packs for font in pack.rglob("*.ttf")})


def unprintable(text: str) -> str:
    """The characters of a text that cannot be printed, each once, at most about a dozen; empty where all can."""
    if ALWAYS.fullmatch(text):
        return ""
    asked = (each for each in dict.fromkeys(text) if not ALWAYS.fullmatch(each) and not _is_silent(each))
    return _without_glyph("".join(asked))


def check_printable(texts: Iterable[tuple[str, str]]) -> None:
    """Raises BadInput, one sentence with the characters, for a text that cannot be printed.

    texts: (description, text).
    """
    known = list(texts)
    if not unprintable("".join(text for _, text in known)):
        return
    for what, text in known:
        missing = unprintable(text)
        if missing:
            named = " ".join(missing[:NAMED_CHARACTERS]) + (" …" if len(missing) > NAMED_CHARACTERS else "")
            more = "" if all(find_spec(name) for name in PACKS) else ", or install breastrig[fonts] (Noto)"
            raise BadInput(f"{what} has characters that the report cannot print: {named}; write it without them{more}.")


def checked_code(code: str) -> str:
    """A patient's code as stored and printed; BadInput for invisible characters, and for unprintable ones."""
    kept = one_line(code)
    check_printable([("The code", kept)])
    return kept


def _is_silent(character: str) -> bool:
    """Joiners and marks, which have no picture of their own."""
    return unicodedata.category(character) in ("Cf", "Mn", "Me", "Cc")


@lru_cache(maxsize=256)
def _without_glyph(characters: str) -> str:
    """The characters without a glyph: all are drawn at once, then by halves, for a plan may have many thousands."""
    if not characters or _glyphs(" ".join(characters)).isdisjoint(_missing()):
        return ""
    half = len(characters) // 2
    if half == 0:
        return characters
    found = _without_glyph(characters[:half])
    return found if len(found) > NAMED_CHARACTERS else found + _without_glyph(characters[half:])


@cache
def _missing() -> frozenset[str]:
    return _glyphs(NO_CHARACTER)


def _glyphs(text: str) -> frozenset[str]:
    """Names of the glyphs that the typesetter draws a text with, as its SVG has them."""
    import typst

    template = b'#set page(width: auto, height: auto)\n#set text(font: "Libertinus Serif")\n#sys.inputs.text'
    drawn = typst.compile(
        template, sys_inputs={"text": text}, format="svg", ignore_system_fonts=True, font_paths=installed_fonts()
    )
    assert isinstance(drawn, bytes)
    return frozenset(GLYPH.findall(drawn.decode()))
