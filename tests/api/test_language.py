"""In which language an answer speaks: the page's cookie, then Accept-Language, then English."""

import json

import pytest
from flask.testing import FlaskClient

from breastrig.api.language import event_said

GONE = "There is no such fit; it may have been deleted."
GONE_DE = "Diese Anpassung gibt es nicht; vielleicht wurde sie gelöscht."


@pytest.mark.parametrize(
    ("cookie", "header", "language"),
    [
        (None, None, "en"),
        (None, "de-AT,de;q=0.9,en;q=0.5", "de"),
        (None, "fr,en;q=0.5", "en"),
        (None, "fr", "en"),
        ("de", "en", "de"),
        ("en", "de", "en"),
        ("xx", "de", "de"),
    ],
)
def test_the_cookie_says_the_language_then_the_browser(
    client: FlaskClient, cookie: str | None, header: str | None, language: str
) -> None:
    if cookie is not None:
        client.set_cookie("breastrig_language", cookie)
    answer = client.get("/api/fits/none", headers={} if header is None else {"Accept-Language": header})
    assert answer.json is not None
    assert answer.json["detail"] == {"en": GONE, "de": GONE_DE}[language]
    assert answer.headers["Content-Language"] == language
    assert {"Accept-Language", "Cookie"} <= {*answer.vary}
    assert answer.json["title"] == "Not Found"  # HTTP's own word


def test_a_stream_and_its_polling_twin_speak_it_too(client: FlaskClient, fit_id: str) -> None:
    english = client.get(f"/api/fits/{fit_id}/events").data
    client.set_cookie("breastrig_language", "de")
    german = client.get(f"/api/fits/{fit_id}/events").data
    assert german == english.replace(b"As asked for.", b"Wie angegeben.") != english
    page = client.get(f"/api/fits/{fit_id}/events.json").json
    assert page is not None
    assert page["events"][0]["event"]["stance_reason"] == "Wie angegeben."


def test_a_stored_file_is_german_where_the_page_reads_it_and_english_on_the_disk(
    client: FlaskClient, fit_id: str
) -> None:
    place = f"/api/fits/{fit_id}/result.json"
    stored = client.get(place)
    client.set_cookie("breastrig_language", "de")
    shown = client.get(place)
    assert shown.json == json.loads(stored.data.replace(b"As asked for.", b"Wie angegeben.")) != stored.json
    assert stored.get_etag()[0] != shown.get_etag()[0]
    client.set_cookie("breastrig_language", "en")
    assert client.get(place).data == stored.data


def test_what_is_edited_and_sent_back_is_the_same_in_every_language(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    before = client.get(place)
    client.set_cookie("breastrig_language", "de")
    after = client.get(place)
    assert (after.json, after.headers.get("ETag")) == (before.json, before.headers.get("ETag"))


def test_the_page_to_sign_in_at_speaks_it(client: FlaskClient) -> None:
    client.set_cookie("breastrig_language", "de")
    answer = client.get("/sign-in")
    assert '<html lang="de">' in answer.text
    assert "Dieser Dienst verlangt kein Token." in answer.text
    assert answer.headers["Content-Language"] == "de"


def test_labels_are_german_and_names_are_not() -> None:
    areola = {"name": "areola_mm", "label": "New areola", "about": "diameter of the new areola; 40 to 45 is usual"}
    english = {"patterns": [{"name": "standing", "label": "Reduction (Wise pattern)", "parameters": [areola]}]}
    areola_de = areola | {"label": "Neue Areola", "about": "Durchmesser der neuen Areola; üblich sind 40 bis 45"}
    german = {"patterns": [{"name": "standing", "label": "Reduktion (Wise-Muster)", "parameters": [areola_de]}]}
    assert json.loads(event_said(json.dumps(english).encode(), "de")) == german
    verdict = json.dumps({"verdict": {"about": ["left"]}}).encode()  # what a program reads
    assert json.loads(event_said(verdict, "de")) == json.loads(verdict)


def test_what_people_and_files_call_things_stays_as_it_is() -> None:
    line = {"kind": "line", "name": "left", "label": "left"}
    segment = {"number": 2, "name": "Tissue 1", "label": "left breast", "why": "It is the largest segment."}
    english = {"items": [line], "shapes": [{"name": "left", "label": "left"}], "segments": [segment]}
    german = english | {"segments": [segment | {"name": "Gewebe 1", "why": "Es ist das größte Segment."}]}
    assert json.loads(event_said(json.dumps(english).encode(), "de")) == german


def test_a_plan_that_was_read_in_german_can_be_replaced(client: FlaskClient, scan_id: str) -> None:
    plan = client.get(f"/api/scans/{scan_id}").json["links"]["plan"]  # type: ignore[index]
    client.set_cookie("breastrig_language", "de")
    line = {"id": "a", "kind": "line", "scan": scan_id, "name": "left", "label": "left"}
    items = [line | {"points": [[0, 300, 130], [20, 300, 128]]}]
    tag = '"0"'
    for after in ("", "-de"):  # as it is, and as an answer that says something of ours has it
        put = client.put(plan, json={"items": items}, headers={"If-Match": f'{tag[:-1]}{after}"'})
        assert put.status_code == 200, put.json
        read = client.get(plan)
        assert [item["label"] for item in read.json["items"]] == ["left"]  # type: ignore[index]
        tag = read.headers["ETag"]
    assert tag == client.get(plan, headers={"Cookie": "breastrig_language=en"}).headers["ETag"]
