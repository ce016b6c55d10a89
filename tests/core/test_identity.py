"""Codes and file names: nothing of the patient's name, and nothing that a file system refuses."""

from datetime import UTC, datetime

import pytest

from breastrig.core.identity import LETTERS, Identity, file_name, random_code


def test_random_codes_have_no_letters_that_are_taken_for_others() -> None:
    codes = {random_code() for _ in range(300)}
    assert len(codes) == 300
    assert {len(code) for code in codes} == {7}
    assert {code[3] for code in codes} == {"-"}
    assert set("".join(codes)) - {"-"} <= set(LETTERS)
    assert not set(LETTERS) & set("0O1I5S2Z8B6GU")


@pytest.mark.parametrize(
    ("code", "stances", "name"),
    [
        ("K7M-4QX", "standing", "K7M-4QX_standing_2026-11-25_report.pdf"),
        ("Klinik Süd/7 ; x", "standing supine", "Klinik-Sud-7-x_standing-supine_2026-11-25_report.pdf"),
        ('../..\r\n"', "supine", "no-code_supine_2026-11-25_report.pdf"),
        ("漢字", "", "no-code_2026-11-25_report.pdf"),
    ],
)
def test_names_of_files(code: str, stances: str, name: str) -> None:
    assert file_name(code, stances, "2026-11-25", "report.pdf") == name


def test_the_day_is_that_of_the_scan_else_of_the_report() -> None:
    made = datetime(2026, 11, 25, tzinfo=UTC)
    assert Identity("K", made, ("", "2026-11-20")).day == "2026-11-20"
    assert Identity("K", made, ("", "")).day == "2026-11-25"
    assert Identity("K").day == ""
