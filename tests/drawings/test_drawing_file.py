"""Drawing files of others: what they mean, and one sentence for each way in which they are wrong."""

import json
from typing import Any

import numpy as np
import pytest

from breastrig.core.errors import BadDrawing
from breastrig.drawings.drawing_file import parsed_drawing
from breastrig.rig.model import Rig

LINE = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]


def test_a_file_has_its_own_unit_or_the_scans(toy_rig: Rig) -> None:
    document: dict[str, Any] = {"schema": "breastrig/drawing@1", "shapes": [{"name": "cut", "points": LINE}]}
    (shape,) = parsed_drawing(document, toy_rig, "cm").on_scan
    np.testing.assert_allclose(shape.points, 0.01 * np.array(LINE))
    (shape,) = parsed_drawing(json.dumps(document | {"unit": "mm"}).encode(), toy_rig, "cm").on_scan
    np.testing.assert_allclose(shape.points, 0.001 * np.array(LINE))
    assert (shape.closed, shape.color, shape.bridged.tolist()) == (False, "#101010", [False, False])


def test_shapes_on_the_model_are_kept_apart(toy_rig: Rig) -> None:
    places = [{"face": 3, "barycentric": [0.2, 0.3, 0.5]}]
    document = {"shapes": [{"name": "a", "surface_points": places}, {"name": "b", "points": LINE}]}
    found = parsed_drawing(document, toy_rig, "m")
    assert [shape.name for shape in found.on_model] == ["a"]
    assert [shape.name for shape in found.on_scan] == ["b"]
    assert found.on_model[0].points.faces.tolist() == [3]


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"Dear surgeon", "is not JSON"),
        (b"[" * 100_000, "is not JSON"),
        ({"shapes": []}, "is empty"),
        ({"shapes": [{"name": "cut"}]}, "is empty"),
        ({"schema": "breastrig/landmarks@1", "shapes": []}, "schema"),
        ({"shapes": [{"name": "cut", "points": [[1.0, 2.0]]}]}, "points"),
        ({"shapes": [{"name": "cut", "points": [[1.0, 2.0, float("nan")]]}]}, "points"),
        ({"shapes": [{"name": "cut", "points": LINE, "bridged": [True]}]}, "bridged"),
        ({"shapes": [{"name": "cut", "points": LINE}] * 2}, 'Two shapes of this drawing are called "cut"'),
        ({"shapes": [{"name": "cut", "points": LINE * 30_000}]}, "60000 points; at most 50000"),
        ({"unit": "mile", "shapes": [{"name": "cut", "points": LINE}]}, "unit"),
        ({"shapes": [{"name": "a", "surface_points": [{"face": 99_999, "barycentric": [1, 0, 0]}]}]}, "another model"),
        (
            {"shapes": [{"name": "a", "surface_points": [{"face": 0, "barycentric": [2, 0, 0]}]}]},
            "outside its triangle",
        ),
    ],
)
def test_what_is_wrong_is_one_sentence(content: Any, sentence: str, toy_rig: Rig) -> None:
    with pytest.raises(BadDrawing, match=sentence) as error:
        parsed_drawing(content, toy_rig, "m")
    assert "\n" not in str(error.value)
    assert str(error.value).endswith(".")
