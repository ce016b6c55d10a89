"""Patients: whose scan a scan is, the list to work through, and plans that nobody overwrites unseen."""

import io
import json
import re
from collections.abc import Iterator
from typing import Any

import pytest
from flask.testing import FlaskClient
from helpers.on_disk import bytes_below
from helpers.problems import problem
from PIL import Image

from breastrig.core.identity import LETTERS
from breastrig.service.service import Service
from breastrig.storage.documents.patients import put_plan

LINE = {"kind": "line", "name": "incision", "closed": False, "color": "#b83280", "points": [[70.0, 350.0, 120.0]]}
TUMOUR = {"kind": "tumour", "side": "L", "clock": 10.0, "distance_mm": 45.0, "radius_mm": 12.0, "depth_mm": 20.0}

LESION = {"kind": "lesion", "name": "MRI 1", "center": [70.0, 350.0, 100.0], "radius_mm": 6.0}


@pytest.fixture
def add(client: FlaskClient, torso: bytes) -> Iterator[Any]:
    """Adds scans; what is left of them is deleted at the end."""
    made: list[str] = []

    def one(patient: str | None = None, **more: str) -> dict[str, Any]:
        form: dict[str, Any] = {"file": (io.BytesIO(torso), "torso.ply"), "again": "true"} | more
        answer = client.post("/api/scans", data=form if patient is None else form | {"patient": patient})
        assert answer.status_code == 201, answer.json
        made.append(answer.json["id"])
        return dict(answer.json)

    yield one
    for scan in made:
        client.delete(f"/api/scans/{scan}")


def plan_of(scan: dict[str, Any]) -> str:
    return str(scan["links"]["plan"])


def item(scan: dict[str, Any], of: dict[str, Any], name: str) -> dict[str, Any]:
    return of | {"id": name, "scan": scan["id"]}


def put(client: FlaskClient, scan: dict[str, Any], items: list[dict[str, Any]], seen: str) -> Any:
    return client.put(plan_of(scan), json={"items": items}, headers={"If-Match": seen})


def test_each_scan_is_of_a_patient_and_a_second_one_can_be_of_the_same(client: FlaskClient, add: Any) -> None:
    first = add()
    second, other = add(first["patient"]), add()
    assert second["patient"] == first["patient"] != other["patient"]
    patient = client.get(first["links"]["patient"]).json
    assert [scan["id"] for scan in patient["scans"]] == [first["id"], second["id"]]
    assert patient["plan_version"] == 0
    assert patient["planned"] == {"patterns": [], "lines": 0, "lesions": 0}
    assert [scan["kind"] for scan in patient["scans"]] == ["surface", "surface"]
    assert re.fullmatch(rf"[{LETTERS}]{{3}}-[{LETTERS}]{{3}}", patient["code"]), "a random one"
    renamed = client.patch(patient["links"]["self"], json={"code": "  "}).json["code"]
    assert renamed != patient["code"]
    assert re.fullmatch(rf"[{LETTERS}]{{3}}-[{LETTERS}]{{3}}", renamed), "no patient is without a code"
    assert all(scan["delete_at"] > scan["created_at"] for scan in patient["scans"])


def test_a_scan_of_an_unknown_patient_is_refused_and_nothing_kept(
    client: FlaskClient, service: Service, torso: bytes
) -> None:
    before = sorted(service.storage.root.rglob("scan.json"))
    answer = client.post("/api/scans", data={"file": (io.BytesIO(torso), "t.ply"), "patient": "nobody"})
    assert "no such patient" in problem(answer, 404)
    assert sorted(service.storage.root.rglob("scan.json")) == before


def test_a_plan_is_kept_whole_with_its_ids_and_versions(client: FlaskClient, add: Any) -> None:
    scan = add()
    empty = client.get(plan_of(scan))
    assert (empty.json["items"], empty.json["version"], empty.json["whole"]) == ([], 0, False)
    note = item(scan, {"kind": "note", "text": "wants it smaller", "point": None}, "n")
    pattern = item(scan, {"kind": "pattern", "name": "lumpectomy", "parameters": {}}, "p")
    line = item(scan, LINE | {"ink": ["ink_1", "ink_4"]}, "a")
    items = [line, item(scan, TUMOUR, "t"), pattern, note]
    answer = put(client, scan, items, empty.headers["ETag"])
    assert answer.status_code == 200, answer.json
    found = client.get(plan_of(scan))
    assert found.headers["ETag"] == answer.headers["ETag"] != empty.headers["ETag"]
    assert found.headers["Cache-Control"] == "no-store"
    assert [{key: each[key] for key in sent} for each, sent in zip(found.json["items"], items, strict=True)] == items
    assert found.json["scans"] == [
        {"id": scan["id"], "stance": scan["stance"]["proposed"], "sha256": found.json["scans"][0]["sha256"]}
    ]
    again = put(client, scan, items[:1], f"W/{answer.headers['ETag']}")  # as a proxy that compresses makes of it
    assert (answer.json["version"], again.json["version"]) == (1, 2)
    earlier = client.get(f"{plan_of(scan)}/versions/1").json
    assert [each["id"] for each in earlier["items"]] == ["a", "t", "p", "n"]
    problem(client.get(f"{plan_of(scan)}/versions/7"), 404)


@pytest.mark.slow
def test_the_longest_plan_that_the_schema_allows_is_kept(client: FlaskClient, add: Any) -> None:
    """With every digit that a page sends, and notes in letters of three bytes each."""
    scan = add()
    points = [[70.0 + x / 3.0, 350.0 + x / 3.0, 120.0 + x / 7.0] for x in (k / 2500 for k in range(250))]
    more = {"bridged": [False] * 250, "error_mm": [5.0 / 3.0] * 250, "label": "l" * 200, "color": "#123456"}
    lines = [item(scan, LINE | more | {"points": points, "name": f"{k:0100}"}, f"{k:064}") for k in range(200)]
    notes = [
        item(scan, {"kind": "note", "text": "ж" * 2_000, "point": [70.1, 350.2, 120.3]}, f"n{k}") for k in range(300)
    ]
    body = json.dumps({"items": lines + notes})
    assert 5_000_000 < len(body) < 12_000_000
    headers = {"If-Match": client.get(plan_of(scan)).headers["ETag"]}
    answer = client.put(plan_of(scan), data=body, headers=headers, content_type="application/json")
    assert answer.status_code == 200, answer.json
    kept = client.get(plan_of(scan)).json["items"]
    assert [each["id"] for each in kept] == [each["id"] for each in lines + notes]
    assert kept[0]["points"] == points


def test_who_has_not_seen_the_plan_does_not_replace_it(client: FlaskClient, add: Any) -> None:
    scan = add()
    first = put(client, scan, [item(scan, LINE, "a")], '"0"')
    assert first.status_code == 200
    late = put(client, scan, [item(scan, LINE, "b")], '"0"')
    assert "changed this plan" in problem(late, 412)
    assert late.headers["ETag"] == first.headers["ETag"]
    for seen in ("*", '"1"', '"99999999999999999999"', ""):
        problem(put(client, scan, [], seen), 412)
    assert "If-Match" in problem(client.put(plan_of(scan), json={"items": []}), 428)
    assert [each["id"] for each in client.get(plan_of(scan)).json["items"]] == ["a"]


NO_ITEMS: list[tuple[dict[str, Any], str]] = [  # the schema's own refusals are those of tests/drawings
    (TUMOUR | {"id": "t", "scan": "nobody"}, "none of this patient"),
    (TUMOUR | {"id": "t", "clock": 14.0}, "clock"),
    (LINE | {"id": "a", "points": [[70.0, 350.0, 9000.0]]}, "outside of the scan"),
    (LESION | {"id": "m", "center": [0.07, 0.35, 9000.0]}, "outside of the scan"),
    ({"id": "n", "kind": "note", "text": "not the left: \U0001f642"}, "A note has characters that the report"),
    (LINE | {"id": "a", "name": "తెలుగు"}, "The name of a line has characters that the report cannot print: త"),
    (LESION | {"id": "m", "name": "తెలుగు"}, "The name of a lesion has characters that the report cannot print: త"),
    ({"id": "p", "kind": "pattern", "name": "tattoo", "parameters": {}}, "tattoo"),
    ({"id": "p", "kind": "pattern", "name": "lumpectomy", "parameters": {"size": 1.0}}, "has no parameters"),
    ({"id": "p", "kind": "pattern", "name": "periareolar", "parameters": {"outer_mm": 1e20}}, "cannot be 1e+20"),
]


def test_what_cannot_be_planned_is_refused(client: FlaskClient, add: Any) -> None:
    scan = add()
    for wrong, word in NO_ITEMS:
        assert word in problem(put(client, scan, [{"scan": scan["id"]} | wrong], '"0"'), 422)
    assert client.get(plan_of(scan)).json["version"] == 0


OFF = [0.0, 350.0, 120.0]  # 15 mm under the skin, in the middle of the scan's bounds


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (LINE | {"points": [*LINE["points"], OFF]}, 'Point 2 of "incision" is 1'),
        ({"kind": "note", "text": "here", "point": OFF}, 'Point 1 of "here" is 1'),
    ],
)
def test_what_is_new_lies_on_the_skin_and_what_was_kept_elsewhere_can_still_be_saved(
    client: FlaskClient, service: Service, add: Any, wrong: dict[str, Any], said: str
) -> None:
    scan = add()
    new, good = item(scan, wrong, "w"), item(scan, LINE | {"name": "good"}, "g")
    answer = problem(put(client, scan, [good, new], '"0"'), 422)
    assert answer.startswith(said)
    assert answer.endswith("draw on the skin, and check that drawing and scan have the same unit and frame.")
    assert client.get(plan_of(scan)).json["version"] == 0
    kept = f'"{put_plan(service.storage, scan["patient"], [new], "0").etag}"'
    named = {"name": "renamed"} if "name" in new else {"text": "there"}
    renamed = put(client, scan, [new | named, good], kept)
    assert renamed.status_code == 200
    nearer = [0.0, 350.0, 121.0]
    moved = {"points": [*LINE["points"], nearer]} if "points" in new else {"point": nearer}
    problem(put(client, scan, [new | named | moved], renamed.headers["ETag"]), 422)


def test_lines_that_are_sent_as_a_drawing_become_items_and_leave_the_others_alone(
    client: FlaskClient, add: Any
) -> None:
    first = add()
    second = add(first["patient"])
    put(client, first, [item(first, TUMOUR, "t"), item(first, LINE, "a"), item(second, LINE, "b")], '"0"')
    shape = {key: value for key, value in LINE.items() if key != "kind"}
    answer = client.put(first["links"]["drawing"], json={"shapes": [shape, shape | {"name": "new"}]})
    assert answer.status_code == 200, answer.json
    items = client.get(plan_of(first)).json["items"]
    assert [(each["id"], each["kind"], each["scan"]) for each in items] == [
        ("t", "tumour", first["id"]),
        ("b", "line", second["id"]),
        ("a", "line", first["id"]),  # the name that it had, so the id that it had
        ("line-2", "line", first["id"]),
    ]
    assert [each["name"] for each in client.get(first["links"]["drawing"]).json["shapes"]] == ["incision", "new"]


def test_a_scan_moves_to_another_patient_with_what_was_planned_on_it(client: FlaskClient, add: Any) -> None:
    first, second = add(), add()
    put(client, first, [item(first, LINE, "a")], '"0"')
    put(client, second, [item(second, TUMOUR, "a")], '"0"')
    answer = client.put(f"/api/scans/{second['id']}/patient", json={"patient": first["patient"], "again": True})
    assert [scan["id"] for scan in answer.json["scans"]] == [first["id"], second["id"]]
    problem(client.get(second["links"]["patient"]), 404)  # she had no other scan
    items = client.get(plan_of(first)).json["items"]
    assert [(each["id"], each["kind"]) for each in items] == [("a", "line"), ("a-2", "tumour")]
    problem(client.put(f"/api/scans/{second['id']}/patient", json={"patient": "nobody"}), 404)
    problem(client.put("/api/scans/nobody/patient", json={"patient": first["patient"]}), 404)


def test_deleting_a_patient_deletes_all(client: FlaskClient, service: Service, add: Any) -> None:
    first = add()
    second = add(first["patient"])
    client.patch(first["links"]["patient"], json={"code": "secret-code-17"})
    put(client, first, [item(first, LINE, "a"), item(second, LINE, "b")], '"0"')
    assert client.delete(first["links"]["patient"]).status_code == 204
    assert client.delete(first["links"]["patient"]).status_code == 204
    for scan in (first, second):
        problem(client.get(f"/api/scans/{scan['id']}"), 404)
    problem(client.get(plan_of(first)), 404)
    assert b"secret-code-17" not in bytes_below(service.storage.root)


def test_the_list_is_paged_the_newest_first_and_searched_by_code(client: FlaskClient, add: Any) -> None:
    scans = [add() for _ in range(3)]
    for number, scan in enumerate(scans):
        answer = client.patch(scan["links"]["patient"], json={"code": f"  Ward 7 /  {number}%_"})
        assert answer.json["code"] == f"Ward 7 / {number}%_"
    page = client.get("/api/patients?limit=2&search=WARD 7 /").json
    assert [each["code"] for each in page["patients"]] == ["Ward 7 / 2%_", "Ward 7 / 1%_"]
    rest = client.get(page["next"]).json
    assert [each["code"] for each in rest["patients"]] == ["Ward 7 / 0%_"]
    assert rest["next"] is None
    assert client.get("/api/patients?search=1%25_").json["patients"][0]["id"] == scans[1]["patient"]
    problem(client.patch(scans[0]["links"]["patient"], json={"code": "x" * 61}), 422)
    said = problem(client.patch(scans[0]["links"]["patient"], json={"code": "a\x00b"}), 422)
    assert said == "code: Line breaks and other control characters are not taken; leave them out."
    for code, why in (("A\u202e1", "nobody sees (U+202E)"), ("A\u200b1", "nobody sees"), ("తెలుగు", "cannot print: త")):
        assert why in problem(client.patch(scans[0]["links"]["patient"], json={"code": code}), 422)
    problem(client.get("/api/patients", query_string={"search": "\x00"}), 422)
    problem(client.patch("/api/patients/nobody", json={"code": "x"}), 404)


@pytest.mark.slow
def test_the_list_is_sorted_by_the_service_over_all_its_pages(client: FlaskClient, add: Any) -> None:
    scans = [add() for _ in range(5)]
    codes = ["zz 10", "ZZ 9", "zz 9 b", "zz 010", "zz"]
    for scan, code in zip(scans, codes, strict=True):
        client.patch(scan["links"]["patient"], json={"code": code})
    add(scans[2]["patient"])
    without = add()["patient"]

    def pages(query: str) -> list[dict[str, Any]]:
        found, address = [], f"/api/patients?limit=2&{query}"
        while address is not None:
            page = client.get(address).json
            found += page["patients"]
            address = page["next"]
        return found

    ordered = [each["code"] for each in pages("sort=code&search=zz")]
    assert ordered == ["zz", "ZZ 9", "zz 9 b", "zz 010", "zz 10"]
    everybody = pages("sort=code")
    assert all(each["code"] for each in everybody)
    assert without in [each["id"] for each in everybody]
    assert len({each["id"] for each in everybody}) == len(everybody)
    soonest = [each["scans"][0]["delete_at"] for each in pages("sort=deletion")]
    assert soonest == sorted(soonest)
    assert len(soonest) == len(everybody)
    problem(client.get("/api/patients?sort=colour"), 422)


def test_each_scan_has_a_small_picture_without_names_in_it(client: FlaskClient, add: Any) -> None:
    scan = add()
    (listed,) = client.get(scan["links"]["patient"]).json["scans"]
    answer = client.get(listed["thumbnail"])
    with Image.open(io.BytesIO(answer.data)) as picture:
        assert (picture.format, picture.size, picture.info.get("Comment")) == ("PNG", (144, 180), None)
        shown = picture.convert("RGBA").getchannel("A")
        assert 0.1 < sum(shown.histogram()[128:]) / (144 * 180) < 0.95
    problem(client.get("/api/scans/nobody/thumbnail.png"), 404)


def test_another_patients_plan_and_drawing_are_asked_about(client: FlaskClient, add: Any) -> None:
    """Every fixed scanner has one frame: another's lines and tumours lie near this skin too."""
    scan = add()
    code, sha256 = scan["patient_code"], scan["sha256"]
    other = {"id": "x", "stance": "standing", "sha256": "ab" * 32}
    items = [item(scan, LINE, "a"), item(scan, TUMOUR, "t")]
    place, headers = plan_of(scan), {"If-Match": client.get(plan_of(scan)).headers["ETag"]}
    for whose in ({"patient": "P-9"}, {"patient": "P-9", "scans": [other]}, {"scans": [other]}):
        said = problem(client.put(place, json={"items": items} | whose, headers=headers), 409)
        assert f"not for patient {code}" in said
        assert (" P-9" in said) is ("patient" in whose)  # with its space: a drawn code may have P-9 in it
        assert said.endswith("say same_patient.")
        drawing = {"shapes": [LINE]} | {key: value for key, value in whose.items() if key == "patient"}
        if "patient" in whose:
            problem(client.put(f"/api/scans/{scan['id']}/drawing", json=drawing), 409)
    assert client.get(place).json["items"] == []
    for whose in ({"patient": code}, {"patient": "P-9", "scans": [other | {"sha256": sha256}]}, {}):
        headers = {"If-Match": client.get(place).headers["ETag"]}
        assert client.put(place, json={"items": items} | whose, headers=headers).status_code == 200
    headers = {"If-Match": client.get(place).headers["ETag"]}
    answer = client.put(f"{place}?same_patient=true", json={"items": items, "patient": "P-9"}, headers=headers)
    assert (answer.status_code, answer.json["patient"]) == (200, code)


def test_the_same_file_twice_is_asked_about(client: FlaskClient, service: Service, torso: bytes, add: Any) -> None:
    first, other = add(), add()
    kept = sorted(service.storage.root.rglob("scan.json"))
    form = {"file": (io.BytesIO(torso), "torso.ply"), "patient": first["patient"]}
    said = problem(client.post("/api/scans", data=form), 409)
    assert said.startswith("This scan is already here: the same file is one of this patient's scans;")
    assert said.endswith("say again.")
    assert sorted(service.storage.root.rglob("scan.json")) == kept
    place, moved = f"/api/scans/{other['id']}/patient", {"patient": first["patient"]}
    problem(client.put(place, json=moved), 409)
    assert client.get(f"/api/patients/{other['patient']}").status_code == 200
    assert client.put(place, json=moved | {"again": True}).status_code == 200
    assert client.put(place, json=moved).status_code == 200, "it is hers already"
    assert add(first["patient"])["patient"] == first["patient"]


def test_the_list_says_in_short_what_is_planned(client: FlaskClient, add: Any) -> None:
    scan = add()
    pattern = {"kind": "pattern", "name": "reduction", "parameters": {}}
    kinds = {"a": LINE, "b": LINE | {"name": "second"}, "t": TUMOUR, "l": LESION, "p": pattern}
    answer = put(client, scan, [item(scan, of, name) for name, of in kinds.items()], "0")
    assert answer.status_code == 200, answer.json
    assert client.get(scan["links"]["patient"]).json["planned"] == {"patterns": ["reduction"], "lines": 2, "lesions": 2}
