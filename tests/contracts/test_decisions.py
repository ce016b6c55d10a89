"""A decision is a page: its parts, what implements it today, one table; raw tables are clean CSV files beside it."""

import csv
import re
from pathlib import Path

import pytest

MOST_WORDS = 300  # outside its table: of a page that holds two decisions; of the others about 200
PARTS = ("Problem", "Decision", "Evidence", "Rejected", "Consequences")
STATUS = re.compile(r"(Accepted|Superseded)\b.*?\(2\d{3}-\d\d(?:-\d\d)?\)")


def faults(name: str, text: str, repository: Path) -> list[str]:
    """What a page of this file name lacks or has too much of, one sentence each; none of a page as it should be."""
    lines = text.splitlines()
    words = sum(len(line.split()) for line in lines if not line.startswith("|"))
    tables = len(re.findall(r"(?:^\|.*\n)+", text + "\n", re.MULTILINE))
    status = next((line for line in lines[1:] if line), "")
    code = re.findall(r"`([^`]+)`", status.partition("Code: ")[2])
    parts = re.findall(r"^\*\*(\w+)\b[^*]*\*\*(.*)", text, re.MULTILINE)
    found = [part for part, _ in parts]
    linked = set(re.findall(r"\]\(([^)]+\.csv)\)", text))
    beside = {file.name for file in (repository / "docs/decisions").glob(f"{name[:4]}-*.csv")}
    said = {
        f"its title does not begin with {name[:4]}.": not text.startswith(f"# {name[:4]}. "),
        "its status and date do not follow the title": not STATUS.match(status),
        "an accepted one names no Code:": status.startswith("Accepted") and not code,
        f"its parts are {', '.join(found)}": found != list(PARTS),
        "a part is empty": any(not words.strip(" .") for part, words in parts if part not in ("Decision", "Rejected")),
        f"{words} words outside its table": words > MOST_WORDS,
        f"{tables} tables": tables > 1,
        f"the tables beside it are {sorted(beside)}, it links {sorted(linked)}": beside != linked,
    }
    gone = [f"Code: {path} is not there" for path in code if not (repository / path).exists()]
    return [fault for fault, is_so in said.items() if is_so] + gone


@pytest.fixture(scope="module")
def pages(repository: Path) -> dict[str, str]:
    """The text of each decision, by file name."""
    found = {file.name: file.read_text("utf-8") for file in sorted((repository / "docs/decisions").glob("0*.md"))}
    assert len(found) > 30
    return found


def test_each_decision_is_a_page(pages: dict[str, str], repository: Path) -> None:
    wrong = {name: found for name, text in pages.items() if (found := faults(name, text, repository))}
    assert wrong == {}


def test_raw_tables_have_a_name_for_each_column_and_a_value_for_each_name(repository: Path) -> None:
    tables = sorted((repository / "docs/decisions").glob("*.csv"))
    assert tables
    for table in tables:
        with table.open(encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
        assert len(set(header)) == len(header), table.name
        assert all(re.fullmatch(r"[a-z0-9_.]+", column) for column in header), table.name
        assert rows, table.name
        assert {len(row) for row in rows} == {len(header)}, table.name


def test_the_index_has_a_row_for_each(pages: dict[str, str], repository: Path) -> None:
    index = (repository / "docs/decisions/index.md").read_text("utf-8")
    rows = dict(re.findall(r"^\|\[\d{4}\]\(([^)]+)\)\|(.+?)\|\w.*\|.+\|$", index, re.MULTILINE))
    assert rows == {name: text.splitlines()[0][len("# 0000. ") :] for name, text in pages.items()}
    for name, text in pages.items():
        status = text.splitlines()[2].split()[0]
        assert re.search(rf"\({name}\)\|.+\|{status}\b", index), f"the index has another status of {name}"


def test_the_check_sees_a_diary(repository: Path) -> None:
    diary = "# 0001. Numbers\n\n**Decision.** Those.\n\n**Tried.** " + "this " * 300 + "\n\n|a|\n|-|\n\n|b|\n|-|\n"
    assert len(faults("0002-numbers.md", diary, repository)) == 5
    page = "# 0002. Use numbers\n\nAccepted (2026-11-28). Code: `gone.py`\n"
    assert "Code: gone.py is not there" in faults("0002-numbers.md", page, repository)
