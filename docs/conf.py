"""Sphinx: Markdown by MyST, the reference of `import breastrig` from its docstrings.  Nothing is fetched."""

from breastrig import __version__

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
