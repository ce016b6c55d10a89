"""The page works without the internet: nothing that it loads comes from anywhere but its own service.

Sources and built page, three.js included, are held to one strict rule: no outside address at all, but the names
of XML languages.
"""

import re
from pathlib import Path

import pytest

from breastrig.scan.landmarks.landmark_files import SLICER_SCHEMA

ADDRESS = re.compile(
    r"""(?:(?:https?|wss?):|(?<=["'`(=]))//(?P<host>[a-z0-9-]+(?:\.[a-z0-9-]+)*\.[a-z]{2,})[^\s"'`<>)\\]*""",
    re.IGNORECASE,
)
NAMES_OF_LANGUAGES = {"www.w3.org"}  # xmlns: a name, never fetched
NAME_OF_FORMAT = SLICER_SCHEMA.split(":", 1)[1]  # a name as well, in the landmark files that the page saves
LOADS = re.compile(
    r"""(?:\bsrc|\bhref|\baction|\bposter)\s*=\s*["']?\s*(?:https?:)?//"""
    r"""|url\(\s*["']?(?:https?:)?//"""
    r"""|@import\s+["'](?:https?:)?//"""
    r"""|\b(?:fetch|import|importScripts|EventSource|WebSocket|Worker)\(\s*["'`](?:https?:|wss?:)?//""",
    re.IGNORECASE,
)
TEXT = {".html", ".css", ".js", ".mjs", ".ts", ".svg", ".json", ".webmanifest"}


def texts(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.suffix in TEXT
    }


def outside_addresses(text: str) -> list[str]:
    found = [match for match in ADDRESS.finditer(text) if match["host"].lower() not in NAMES_OF_LANGUAGES]
    return [match[0] for match in found if not match[0].endswith(NAME_OF_FORMAT)]


@pytest.fixture(scope="module")
def built_page(repository: Path) -> dict[str, str]:
    folder = repository / "web" / "dist"
    assert (folder / "index.html").is_file(), "the page is not built: run `make page`"
    return texts(folder)


def test_the_sources_of_the_page_name_no_outside_address(repository: Path) -> None:
    sources = texts(repository / "web" / "src") | {"index.html": (repository / "web" / "index.html").read_text("utf-8")}
    found = {name: outside_addresses(text) for name, text in sources.items()}
    assert not {name: addresses for name, addresses in found.items() if addresses}


def test_the_built_page_loads_nothing_from_outside(built_page: dict[str, str]) -> None:
    assert not {name: LOADS.findall(text) for name, text in built_page.items() if LOADS.search(text)}


def test_the_built_page_names_no_outside_address(built_page: dict[str, str]) -> None:
    found = {name: outside_addresses(text) for name, text in built_page.items()}
    assert not {name: addresses for name, addresses in found.items() if addresses}


@pytest.mark.parametrize(
    "text",
    [
        '<script src="https://cdn.example.com/three.js"></script>',
        "<link href=//fonts.example.com/css>",
        "body { background: url(https://example.com/a.png) }",
        'import("https://example.com/a.js")',
        "fetch(`https://example.com/`)",
    ],
)
def test_what_would_be_loaded_from_outside_is_found(text: str) -> None:
    assert LOADS.search(text)
    assert outside_addresses(text)
