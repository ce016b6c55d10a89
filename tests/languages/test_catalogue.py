"""The catalogues have every sentence and word of the package, and no others: python server/packaging/messages.py"""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from breastrig.languages.catalogue import LANGUAGES, PLACE, entries

OTHERS = [language for language in LANGUAGES if language != "en"]
LONGEST = {"de": 22}  # characters of a word of a table's head or of a label, that no hyphen parts


@pytest.fixture(scope="module")
def messages(repository: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("messages", repository / "server/packaging/messages.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("language", OTHERS)
def test_every_sentence_is_translated_and_none_is_kept_that_nobody_says(messages: ModuleType, language: str) -> None:
    said = messages.all_msgids()
    assert len(said) > 1500
    known = {msgid: text for msgid, text in entries(language).items() if msgid}
    assert said.keys() - known.keys() == set(), "run server/packaging/messages.py, then write the translations"
    assert known.keys() - said.keys() == set(), "run server/packaging/messages.py"
    assert [msgid for msgid, text in known.items() if not text] == [], "write the translations"


def test_every_word_of_the_list_is_said(messages: ModuleType) -> None:
    lines = messages.WORDS.read_text("utf-8").splitlines()
    words = [line for line in lines if line and not line.startswith("# ")]
    assert set(words) - messages.words().keys() == set(), "take them out of words.txt"
    assert len(set(words)) == len(words)


@pytest.mark.parametrize("language", OTHERS)
def test_places_are_the_same_in_both_languages(language: str) -> None:
    def places(text: str) -> set[str]:
        return {number for number, _ in PLACE.findall(text)}

    known = entries(language).items()
    assert [msgid for msgid, text in known if msgid and places(msgid) != places(text)] == []
    ends = [(msgid, text) for msgid, text in known if msgid and msgid[-1] in ".?" and msgid[-1] != text[-1]]
    assert ends == []


@pytest.mark.parametrize("language", OTHERS)
def test_words_of_tables_fit_their_columns(repository: Path, language: str) -> None:
    """A word of a head or a label stands in a column of 30 mm and more, in type of 7.5 to 9 points."""
    words = entries(language)
    templates = (repository / "server" / "breastrig" / "report").rglob("*.typ")
    heads = {word for file in templates for word in re.findall(r't\("([^"]{1,40})"\)', file.read_text("utf-8"))}
    long = {part for word in heads for part in re.split(r"[\s–-]", words[word]) if len(part) > LONGEST[language]}
    assert long == set()


def test_the_extraction_sees_alternatives_and_values_that_are_made_elsewhere(
    messages: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "core").mkdir()
    (tmp_path / "core" / "errors.py").write_text("class BadInput(Exception): ...\n")
    (tmp_path / "some.py").write_text(
        'GONE = "It is gone; look {where}."\n'
        "def fail(count, far):\n"
        '    what = "one file" if count == 1 else f"{count} files"\n'
        "    raise BadInput(f\"{what} {'is' if count == 1 else 'are'} {far:.1f} mm off.\")\n"
        "def gone():\n"
        '    raise BadInput(GONE.format(where="there"))\n'
    )
    monkeypatch.setattr(messages, "PACKAGE", tmp_path)
    package = messages.Package()
    package.collect()
    assert set(package.found) == {
        "one file is {0:.1f} mm off.",
        "one file are {0:.1f} mm off.",
        "{0} files is {1:.1f} mm off.",
        "{0} files are {1:.1f} mm off.",
        "It is gone; look {0}.",
    }
