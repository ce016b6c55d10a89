"""What a person has cut out of a scan: kept with it, known to fits and proposals, deleted with it."""

from pathlib import Path

import pytest
from flask.testing import FlaskClient
from helpers.waiting import until

from breastrig.cases.fits import find_fit
from breastrig.service.service import Service
from breastrig.storage.documents.scans import StoredScan, cut_facts
from breastrig.use.cases.case_work import job_of

PICTURE = [5.0, 0, 0, 0, 0, 5.0, 0, 0, 0, 0, -1.0, 0, 0, 0, 0, 1.0]
CUT = {"to_picture": PICTURE, "lasso": [[0.1, -0.2], [0.4, -0.2], [0.25, 0.123456789012]]}
OTHER = {"to_picture": PICTURE, "lasso": [[-0.1, -0.2], [-0.4, -0.2], [-0.25, 0.3], [-0.2, 0.3]]}


def test_cuts_are_kept_replaced_and_deleted_with_the_scan(client: FlaskClient, service: Service, scan_id: str) -> None:
    place = client.get(f"/api/scans/{scan_id}").json["links"]["cuts"]
    assert place == f"/api/scans/{scan_id}/cuts"
    assert client.get(place).json == {"cuts": [], "digest": ""}
    put = client.put(place, json={"cuts": [CUT, OTHER]})
    assert put.status_code == 200, put.json
    assert put.json["cuts"] == [CUT, OTHER]
    assert client.get(place).json == put.json
    assert len(put.json["digest"]) == 16
    one = client.put(place, json={"cuts": [OTHER]}).json
    assert one["digest"] not in ("", put.json["digest"])
    assert client.put(place, json={"cuts": [CUT, OTHER]}).json["digest"] == put.json["digest"]
    assert client.delete(f"/api/scans/{scan_id}").status_code == 204
    assert client.get(place).status_code == 404
    assert client.put(place, json={"cuts": []}).status_code == 404
    assert not [file for file in service.storage.root.rglob("cuts.json") if scan_id in str(file)]


def test_who_says_which_cuts_were_seen_replaces_no_others(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/cuts"
    first = client.put(place, json={"cuts": [CUT]}, headers={"If-Match": '""'})
    assert first.status_code == 200, first.json
    late = client.put(place, json={"cuts": [OTHER]}, headers={"If-Match": '""'})
    assert late.status_code == 412
    assert late.json["detail"].startswith("Somebody has changed these cuts since you read them; read them again")
    assert client.get(place).json == first.json
    seen = client.put(place, json={"cuts": [CUT, OTHER]}, headers={"If-Match": f'"{first.json["digest"]}"'})
    assert seen.status_code == 200
    assert client.get(place).json["cuts"] == [CUT, OTHER]


NO_CUTS: list[object] = [
    [{"to_picture": PICTURE[:15], "lasso": CUT["lasso"]}],
    [{"to_picture": PICTURE, "lasso": CUT["lasso"][:2]}],
    [{"to_picture": PICTURE, "lasso": [[0.0, 0.0]] * 301}],
    [{"to_picture": PICTURE, "lasso": [[0.0, 0.0, 0.0]] * 3}],
    [{"to_picture": [1e300, *PICTURE[1:]], "lasso": CUT["lasso"]}],
    [CUT | {"name": "Jane Doe"}],
    [CUT] * 33,
]


def test_what_is_no_cut_is_refused_and_nothing_is_lost(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/cuts"
    kept = client.put(place, json={"cuts": [CUT]}).json
    for cuts in NO_CUTS:
        assert client.put(place, json={"cuts": cuts}).status_code == 422
    assert client.get(place).json == kept


@pytest.mark.slow
def test_a_fit_says_with_which_cuts_it_was_made(
    client: FlaskClient, service: Service, scan_id: str, tmp_path: Path
) -> None:
    place, body = f"/api/scans/{scan_id}/cuts", {"scan": scan_id, "drawing": None}
    before = client.post("/api/fits", json=body).json["id"]
    digest = client.put(place, json={"cuts": [CUT]}).json["digest"]
    after = client.post("/api/fits", json=body).json["id"]
    client.put(place, json={"cuts": []})
    assert client.get(f"/api/fits/{before}").json["cuts"] == ""
    assert client.get(f"/api/fits/{after}").json["cuts"] == digest
    case, scan = service.storage.case_of_fit(after)
    job = job_of(case, scan, find_fit(case, after).document, tmp_path, None)
    assert job.cuts == (CUT,)
    assert job.orientation is None, "that was found with what is cut"


def test_proposals_are_made_once_and_are_those_of_the_scan_as_it_is_cut(
    client: FlaskClient, service: Service, scan_id: str
) -> None:
    proposed = f"/api/scans/{scan_id}/landmarks/proposed"
    made = service.storage.files.scan(scan_id) / "proposed"

    def seen() -> tuple[float, int]:
        until(lambda: client.get(proposed).status_code == 200, "the proposals")
        confidence = client.get(proposed).json["landmarks"]["nipple_L"]["confidence"]
        return confidence, len(made.read_text().splitlines())

    assert [seen(), seen()] == [(0.5, 1), (0.5, 1)]
    client.put(f"/api/scans/{scan_id}/cuts", json={"cuts": [CUT]})
    assert [seen(), seen()] == [(0.25, 2), (0.25, 2)]
    client.put(f"/api/scans/{scan_id}/cuts", json={"cuts": []})
    assert seen()[0] == 0.5


def test_a_scan_of_an_earlier_version_names_its_table_as_it_was_seen() -> None:
    seen = {"normal": [0.0, 0.0, 1.0], "height_m": -0.1}
    wall = {"normal": [0.0, 1.0, 0.0], "height_m": 0.2}

    def shown(**facts: object) -> dict[str, object]:
        return cut_facts(StoredScan("a", "2026-01-01", "stored", "0" * 64, facts))

    assert shown() == {"background": [], "table": None, "other_pieces": []}
    old = shown(background=[wall], orientation={"seen": {"table": seen}})
    assert old == {"background": [wall], "table": seen, "other_pieces": []}
    laid = shown(table=wall, orientation={"seen": {"table": seen}})
    assert laid["table"] == wall
    assert shown(table=None, orientation={"seen": {"table": seen}})["table"] is None
