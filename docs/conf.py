"""Sphinx: Markdown by MyST, the reference of `import breastrig` from its docstrings, a page for each example.

Nothing is fetched.
"""

import ast
from pathlib import Path

from sphinx.application import Sphinx

from breastrig import __version__

DOCS = Path(__file__).parent

project = "BreastRig"
copyright = "the BreastRig maintainers. Research use only, not a medical device"
release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
autodoc_typehints = "signature"
autodoc_member_order = "alphabetical"
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = "BreastRig"
html_show_sourcelink = False


def setup(app: Sphinx) -> None:
    app.connect("builder-inited", lambda _: example_pages())


def example_pages() -> None:
    """docs/examples/NAME.md of each program in server/examples: its docstring, its picture, its text."""
    folder = DOCS / "examples"
    folder.mkdir(exist_ok=True)
    for program in sorted((DOCS.parent / "server" / "examples").glob("*.py")):
        title, _, words = (ast.get_docstring(ast.parse(program.read_text("utf-8"))) or "").partition("\n\n")
        shown = Path("pictures/examples") / f"{program.stem}.webp"
        picture = f"![{title}](../{shown})\n\n" if (DOCS / shown).is_file() else ""
        code = f"```{{literalinclude}} ../../server/examples/{program.name}\n:start-at: import\n```\n"
        page = f"# {title.rstrip('.')}\n\n{words}\n\n{picture}{code}"
        place = folder / f"{program.stem}.md"
        if not place.is_file() or place.read_text("utf-8") != page:
            place.write_text(page, "utf-8")
