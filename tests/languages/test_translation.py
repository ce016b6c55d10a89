"""Finished English sentences in German, and what is left as it is."""

from importlib import resources
from io import BytesIO

import pytest
from babel.messages.pofile import read_po

from breastrig.languages.catalogue import LANGUAGES, catalogue, entries
from breastrig.languages.translation import document_said, said

GONE = "There is no such scan; it may have been deleted."
GONE_DE = "Diesen Scan gibt es nicht; vielleicht wurde er gelöscht."


@pytest.mark.parametrize("language", [each for each in LANGUAGES if each != "en"])
def test_the_catalogue_is_one_of_gettext(language: str) -> None:
    file = resources.files("breastrig.languages").joinpath(language, "LC_MESSAGES", "breastrig.po")
    read = read_po(BytesIO(file.read_bytes()), locale=language, abort_invalid=True)
    assert {each.id: each.string for each in read if each.id} == {k: v for k, v in entries(language).items() if k}


def test_english_needs_no_catalogue() -> None:
    catalogue.cache_clear()
    assert said(GONE, "en") == GONE
    assert catalogue.cache_info().misses == 0


def test_values_are_put_into_the_translation_with_their_numbers_as_the_language_writes_them() -> None:
    text = "The colours of this scan are 1.5 mm apart, too coarse for lines of a pen (at most 1.0 mm); export it {}."
    found = said(text.format("with a finer texture"), "de")
    assert "liegen 1,5 mm auseinander" in found
    assert "(höchstens 1,0 mm)" in found


def test_of_several_readings_the_one_with_more_of_the_catalogues_own_words_counts() -> None:
    both = f"This fit has no results: it is failed. {GONE}"
    assert said(both, "de").endswith(f". {GONE_DE}")
    assert said(GONE.removesuffix("."), "de") == GONE_DE.removesuffix(".")


def test_what_is_not_known_and_what_somebody_typed_stays_as_it_is() -> None:
    assert said("Nobody ever says this.", "de") == "Nobody ever says this."
    assert said(f"Nobody ever says this. {GONE}", "de") == f"Nobody ever says this. {GONE_DE}"
    item = 'The item "left" was made on a scan that is none of this patient; name one that is.'
    assert '"left"' in said(item, "de")


@pytest.mark.parametrize(
    ("english", "german"),
    [
        ("201.3 ±4.2", "201,3 ±4,2"),
        ("1,234.5 mm", "1.234,5 mm"),
        ("2026-11-29", "29.11.2026"),
        ("P-12.5", "P-12.5"),  # a code
        ("1.2.3", "1.2.3"),  # a version
        ("left", "links"),
        ("Left", "Links"),
        ("left, right", "links, rechts"),
    ],
)
def test_numbers_days_and_words(english: str, german: str) -> None:
    assert said(english, "de") == german


def test_only_the_named_fields_of_a_document_are_said() -> None:
    document = {"reason": GONE, "name": GONE, "notes": [GONE, {"text": GONE}], "held": {"text": GONE}}
    assert document_said(document, "de", lambda holder, name: name in ("reason", "notes") or holder == "held") == {
        "reason": GONE_DE,
        "name": GONE,
        "notes": [GONE_DE, {"text": GONE}],
        "held": {"text": GONE_DE},
    }


def test_numbers_of_a_plan_on_both_sides_are_german_with_why_they_are_others() -> None:
    text = "47.9 mm left, 41.4 mm right (asked for: 0 mm; a nipple is not moved down)"
    german = "47,9 mm links, 41,4 mm rechts (verlangt: 0 mm; eine Mamille wird nicht nach unten versetzt)"
    assert said(text, "de") == german
