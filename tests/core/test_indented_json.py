"""What is written is, character by character, what the standard library writes with an indentation of one."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from breastrig.core.documents import indented

numbers = st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.booleans() | st.none()
documents = st.recursive(
    numbers | st.text(max_size=6),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(numbers, max_size=4)
        | st.tuples(inner, inner)
        | st.dictionaries(st.text(max_size=4) | st.integers() | st.booleans() | st.none(), inner, max_size=4)
    ),
    max_leaves=20,
)


@settings(max_examples=80, deadline=None)
@given(documents)
def test_it_is_the_standard_librarys(document: object) -> None:
    assert indented(document) == json.dumps(document, indent=1, allow_nan=False)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
def test_numbers_that_are_not_finite_are_refused(number: float) -> None:
    for document in (number, [number, 1.0], {"a": [[number]]}):
        with pytest.raises(ValueError, match="not JSON compliant"):
            indented(document)


def test_what_json_does_not_know_is_refused() -> None:
    with pytest.raises(TypeError):
        indented({"a": {1, 2}})
