"""Names with a side, and what has none."""

import pytest

from breastrig.core.stances import OUTWARDS, SIDES, split_side


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("nipple_L", ("nipple", "L")),
        ("inframammary_fold_R", ("inframammary_fold", "R")),
        ("mid_sternum", ("mid_sternum", "")),
        ("xiphoid", ("xiphoid", "")),
        ("_L", ("_L", "")),
        ("L", ("L", "")),
    ],
)
def test_a_name_is_split_at_its_side(name: str, parts: tuple[str, str]) -> None:
    assert split_side(name) == parts


def test_outwards_is_to_her_left_on_the_left_and_to_her_right_on_the_right() -> None:
    assert OUTWARDS == {"L": 1.0, "R": -1.0}
    assert [*OUTWARDS] == [*SIDES]
