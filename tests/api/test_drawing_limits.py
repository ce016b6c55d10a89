"""One drawing, four doors: files, reports, drawings that are kept and drawings that are carried take the same."""

import io
import json
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from apiflask import APIFlask
from flask.testing import FlaskClient

from breastrig.core.errors import BadDrawing, BadInput
from breastrig.drawings.drawing_file import checked_drawing, parsed_drawing
from breastrig.drawings.drawing_schema import BLACK, POINTS, SHAPES
from breastrig.rig.model import Rig
from breastrig.use.reports.report import drawn_lines

pytestmark = pytest.mark.long

PLACE = [70.0, 350.0, 120.0]
LINE: dict[str, Any] = {"name": "incision", "points": [PLACE, [60.5, 340.25, 121.0]]}


def one(**changes: Any) -> dict[str, Any]:
    return {"unit": "mm", "shapes": [LINE | changes]}


def many(count: int, points: int) -> dict[str, Any]:
    return {"unit": "mm", "shapes": [{"name": str(k), "points": [[70, 350, 120]] * points} for k in range(count)]}


TAKEN = {
    "plain": one(),
    "with a schema": {"schema": "breastrig/drawing@1"} | one(),
    "with fields of others": one(patient="Ada") | {"notice": "n"},
    "the longest name": one(name="n" * 100),
    "a long title": one() | {"name": "and_" * 250},
    "the longest label": one(label="l" * 200),
    "any colour": one(color="#C5307f"),
    "no colour": one(color=None),
    "bridged": one(bridged=[True, False]),
    "bridged not said": one(bridged=None),
    "bridged said of no point": one(bridged=[]),
    "errors": one(error_mm=[0, 2.5]),
    "one error not known": one(error_mm=[None, 2.5]),
    "the most shapes": many(500, 100),
    "the most points": many(1, 50_000),
}
REFUSED = {
    "no object": (["incision"], "valid"),
    "no shapes": ({"unit": "mm"}, "shapes"),
    "another schema": ({"schema": "breastrig/landmarks@1"} | one(), "schema"),
    "an unknown unit": (one() | {"unit": "mile"}, "unit"),
    "too long a title": (one() | {"name": "n" * 1001}, "name"),
    "no name": ({"unit": "mm", "shapes": [{"points": [PLACE]}]}, "name"),
    "too long a name": (one(name="n" * 101), "name"),
    "too long a label": (one(label="l" * 201), "label"),
    "a colour's name": (one(color="red"), "color"),
    "a colour with more behind": (one(color="#101010;x"), "color"),
    "closed perhaps": (one(closed="perhaps"), "closed"),
    "two coordinates": (one(points=[[0, 0]]), "points"),
    "endless": (one(points=[[0, 0, float("inf")]]), "points"),
    "far too large": (one(points=[[0, 0, 1e300]]), "points"),
    "bridged of another length": (one(bridged=[True]), '"incision" has 2 points but 1 of bridged'),
    "errors of another length": (one(error_mm=[1, 2, 3]), '"incision" has 2 points but 3 of error_mm'),
    "an error below zero": (one(error_mm=[-1, 2]), "error_mm"),
    "an endless error": (one(error_mm=[1, float("inf")]), "error_mm"),
    "two of a name": ({"unit": "mm", "shapes": [LINE, LINE]}, 'Two shapes of this drawing are called "incision"'),
    "too many shapes": (many(501, 1), "at most 500"),
    "too many points": (many(3, 16_667), "50001 points; at most 50000"),
}
# A drawing that is kept has no title, which is passed over.
ONLY_FILES = {"too long a title"}
# What a fit has left may hold a whole plan: it is read however much it is.
LENGTHS = {f"too long a {part}" for part in ("title", "name", "label")}
LIMITS = LENGTHS | {"two of a name", "too many shapes", "too many points"}


@pytest.fixture(scope="module")
def own(app: APIFlask, torso: bytes) -> Iterator[str]:
    """Where the drawing of a scan is kept."""
    client = app.test_client()
    scan_id = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"]
    yield f"/api/scans/{scan_id}/drawing"
    client.delete(f"/api/scans/{scan_id}")


def report_of(drawing: Any, folder: Path) -> None:
    (folder / "drawing.json").write_text(json.dumps(drawing))
    drawn_lines(folder, "mm")


def carried(client: FlaskClient, drawing: Any) -> Any:
    """The fits are unknown, which is said of a drawing that is taken."""
    return client.post("/api/transfers", json={"from_fit": "nothing", "to_fit": "nothing", "drawing": drawing})


SENT = ("plain", "the longest label", "bridged said of no point", "one error not known")


@pytest.mark.slow
def test_what_is_taken_anywhere_is_taken_everywhere(
    client: FlaskClient, own: str, toy_rig: Rig, tmp_path: Path
) -> None:
    for name, drawing in TAKEN.items():
        given = parsed_drawing(json.dumps(drawing).encode(), toy_rig, "mm")
        assert len(given.on_scan) == len(drawing["shapes"])
        report_of(drawing, tmp_path)
        if name in SENT:
            answer = client.put(own, json=drawing)
            assert answer.status_code == 200, answer.json["detail"]
            assert [shape["name"] for shape in answer.json["shapes"]] == [shape["name"] for shape in drawing["shapes"]]
            assert carried(client, drawing).status_code == 404


def test_what_is_refused_anywhere_is_refused_everywhere(client: FlaskClient, own: str, tmp_path: Path) -> None:
    for name, (drawing, words) in REFUSED.items():
        with pytest.raises(BadDrawing) as error:
            checked_drawing(json.dumps(drawing).encode())
        assert words in str(error.value)
        assert str(error.value).endswith(".")
        with nullcontext() if name in LIMITS else pytest.raises(BadInput, match=r"drawing\.json is damaged"):
            report_of(drawing, tmp_path)
        kept, there = client.put(own, json=drawing), carried(client, drawing)
        assert (kept.status_code, there.status_code) == (200 if name in ONLY_FILES else 422, 422), name
        for answer in (there,) if name in ONLY_FILES else (there, kept):
            assert words in answer.json["detail"]
            assert answer.json["detail"].endswith(".")


def test_an_error_band_is_kept_where_it_is_known_and_not_mentioned_elsewhere(client: FlaskClient, own: str) -> None:
    answer = client.put(own, json=one(error_mm=[None, 2.5]))
    assert answer.json["shapes"][0]["error_mm"] == [None, 2.5]
    assert client.get(own).json == answer.json
    assert "error_mm" not in client.put(own, json=one()).json["shapes"][0]


def test_a_line_without_a_colour_is_black_and_of_no_point_nothing_is_said(client: FlaskClient, own: str) -> None:
    (shape,) = client.put(own, json=one(color=None, bridged=[], error_mm=[])).json["shapes"]
    assert shape == LINE | {"label": "", "closed": False, "color": BLACK}


def test_the_description_names_the_limits(client: FlaskClient) -> None:
    said = client.get("/api/openapi.json").json["paths"]["/api/scans/{scan_id}/drawing"]["put"]["description"]
    assert f"At most {SHAPES:,} shapes with {POINTS:,} points together" in said
