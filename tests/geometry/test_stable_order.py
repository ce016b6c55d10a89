"""Sorting numbers with their places packed into them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from breastrig.core.arrays import stable_order

NUMBERS = st.one_of(st.integers(0, 5), st.integers(0, 2**40), st.integers(-(2**62), 2**62))


@given(st.lists(NUMBERS, max_size=40))
def test_as_a_stable_argsort_whatever_the_numbers_are(numbers: list[int]) -> None:
    keys = np.array(numbers, dtype=np.int64)
    np.testing.assert_array_equal(stable_order(keys), np.argsort(keys, kind="stable"))


@pytest.mark.parametrize("bits", [58, 59, 60, 61, 62])
def test_numbers_that_leave_no_room_for_their_places(bits: int) -> None:
    keys = np.array([2**bits, 3, 2**bits - 1, 3, 2**bits + 1, 0, 0, 2**bits])
    np.testing.assert_array_equal(stable_order(keys), np.argsort(keys, kind="stable"))


def test_what_is_sorted_stays_as_it_is() -> None:
    keys = np.array([3, 1, 2])
    stable_order(keys)
    np.testing.assert_array_equal(keys, [3, 1, 2])


def test_narrow_numbers() -> None:
    keys = np.array([200, 7, 200, 255, 7], dtype=np.uint8)
    np.testing.assert_array_equal(stable_order(keys), [1, 4, 0, 2, 3])
