"""Drawing files of others: what they mean, and one sentence for each way in which they are wrong."""

import json
from typing import Any

import numpy as np
import pytest

from breastrig.core.errors import BadDrawing
from breastrig.drawings.drawing_file import lines_on_scan, parsed_drawing, shape_document
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


def test_what_is_written_is_read_back(toy_rig: Rig) -> None:
    shape = {"name": "cut", "closed": True, "color": "#c53030", "points": LINE, "bridged": [False, True]}
    known = shape | {"error_mm": [None, 2.5], "line_error_mm": 1.8}
    lines = parsed_drawing({"shapes": [shape, known | {"name": "scar"}]}, toy_rig, "mm").on_scan
    np.testing.assert_array_equal(lines[1].error, [np.nan, 0.0025])
    assert [shape_document(line, 1e-3) for line in lines] == [shape, known | {"name": "scar"}]


def test_an_error_that_is_known_of_no_point_is_not_written(toy_rig: Rig) -> None:
    document = {"shapes": [{"name": "cut", "points": LINE, "error_mm": [None, None]}]}
    (line,) = parsed_drawing(document, toy_rig, "mm").on_scan
    assert "error_mm" not in shape_document(line, 1e-3)


def test_a_fit_may_leave_no_line_but_none_that_is_not_on_its_scan() -> None:
    assert lines_on_scan(b'{"schema": "breastrig/drawing@1", "name": null, "shapes": []}', "mm") == ()
    places = [{"face": 3, "barycentric": [0.2, 0.3, 0.5]}]
    for shape in ({"name": "a"}, {"name": "a", "surface_points": places}):
        with pytest.raises(BadDrawing, match='"a" has no points on the scan'):
            lines_on_scan({"shapes": [{"name": "b", "points": LINE}, shape]}, "mm")


def test_what_a_fit_has_left_is_read_however_much_it_is(toy_rig: Rig) -> None:
    """A whole plan of allowed items has more lines and points, and longer names, than one request may bring."""
    shapes = [{"name": f"{k % 500} {'x' * 300}", "label": "y" * 300, "points": LINE * 40} for k in range(700)]
    document = {"name": "n" * 2_000, "unit": "mm", "shapes": shapes}
    assert sum(len(line.points) for line in lines_on_scan(document, "m")) == 56_000
    with pytest.raises(BadDrawing):
        parsed_drawing(document, toy_rig, "m")


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
        ({"shapes": [{"name": str(k), "points": LINE * 13_000} for k in range(2)]}, "52000 points; at most 50000"),
        ({"shapes": [{"name": "cut", "points": LINE, "error_mm": [1.0]}]}, "2 points but 1 of error_mm"),
        ({"shapes": [{"name": "a", "surface_points": [{"face": 10**30, "barycentric": [1, 0, 0]}]}]}, "face"),
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


def test_at_most_500_shapes_of_50_000_points_are_taken(toy_rig: Rig) -> None:
    def drawing(shapes: int, points: int) -> dict[str, Any]:
        return {"unit": "mm", "shapes": [{"name": f"{k}", "points": LINE * (points // 2)} for k in range(shapes)]}

    for shapes, points in ((500, 2), (10, 5_000)):
        assert len(parsed_drawing(drawing(shapes, points), toy_rig, "mm").on_scan) == shapes
    for shapes, points, why in ((501, 2, "at most 500"), (10, 5_002, "50020 points; at most 50000 can be kept")):
        with pytest.raises(BadDrawing, match=why):
            parsed_drawing(drawing(shapes, points), toy_rig, "mm")
