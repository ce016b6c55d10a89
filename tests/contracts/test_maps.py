"""The maps of server and page name what is there, and no folder of either is too large to be looked over."""

import re
from pathlib import Path

import pytest

MOST_LINES = 2000  # of the files directly in a folder; a room of more is split by its ideas
ENDINGS = ("/", ".py", ".toml", ".json", ".ts", ".js", ".css", ".md", ".html")
MADE_BY_TOOLS = {"dist/"}


def named_paths(text: str) -> set[str]:
    """What stands in backticks and looks like a path; addresses of the service begin with a slash."""
    words = {word for span in re.findall(r"`([^`\n]+)`", text) for word in span.split() if not span.startswith("npm")}
    return {
        word
        for word in words
        if word.endswith(ENDINGS) and "=" not in word and not word.startswith(("/", "http", ".css"))
    } - MADE_BY_TOOLS


def is_there(path: str, folders: list[Path]) -> bool:
    """In one of the folders; NAME and … stand for any name."""
    pattern = re.sub(r"[A-Z]{2,}|…", "*", path).rstrip("/")
    return any(next(folder.glob(pattern), None) is not None for folder in folders)


@pytest.mark.parametrize(
    ("readme", "places"),
    [
        ("server/README.md", ["server", "server/breastrig"]),
        ("web/README.md", ["web", "web/src", "web/src/*"]),
        ("CONTRIBUTING.md", ["server/breastrig", "model_assets", "model_assets/built", "web/src", "web/src/*"]),
    ],
)
def test_every_path_that_a_map_names_exists(readme: str, places: list[str], repository: Path) -> None:
    paths = named_paths((repository / readme).read_text())
    assert len(paths) > 15
    folders = [repository] + [folder for place in places for folder in repository.glob(place)]
    gone = {path for path in paths if not is_there(path, folders)}
    assert gone == set(), f"{readme} names what is not there: say where it is now, or take it out"


def test_what_is_said_to_be_of_a_file_is_defined_there(repository: Path) -> None:
    """`name` of `room/file.py`"""
    said = re.findall(r"`([\w.]+)`\s+of\s+`([\w/]+\.py)`", (repository / "CONTRIBUTING.md").read_text())
    assert len(said) > 3
    for name, path in said:
        text = (repository / "server" / "breastrig" / path).read_text()
        last = name.rpartition(".")[2]
        is_defined = re.search(rf"^\s*(?:def|class) {last}\b|^{last}(?::.*)? = ", text, re.MULTILINE)
        assert is_defined, f"CONTRIBUTING.md: {name} is not defined in {path}; say where it is now"


def test_every_room_of_the_server_is_in_its_map(repository: Path) -> None:
    package = repository / "server" / "breastrig"
    rooms = {f"{folder.name}/" for folder in package.iterdir() if (folder / "__init__.py").is_file()}
    missing = rooms - named_paths((repository / "server" / "README.md").read_text())
    assert missing == set(), "add a line for each to the table of server/README.md, at its place among the layers"


@pytest.mark.parametrize(("place", "endings"), [("server", {".py"}), ("web/src", {".ts", ".css"})])
def test_no_folder_is_too_large(place: str, endings: set[str], repository: Path) -> None:
    written = [file for file in (repository / place).rglob("*") if file.suffix in endings and ".gen." not in file.name]
    lines: dict[str, int] = {}
    for file in written:
        folder = file.parent.relative_to(repository).as_posix()
        lines[folder] = lines.get(folder, 0) + len(file.read_text().splitlines())
    assert len(lines) > 20
    large = {folder: count for folder, count in lines.items() if count > MOST_LINES}
    assert large == {}, f"more than {MOST_LINES} lines: move files that belong together into a folder of their own"
