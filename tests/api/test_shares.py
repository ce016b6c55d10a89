"""Share links: what they show, what they do not, and when they end."""

import hashlib
import io
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from apiflask import APIFlask
from flask.testing import FlaskClient
from helpers import fake_fit
from helpers.on_disk import bytes_below, kept_below
from helpers.problems import problem
from helpers.shares import expire, shown_files
from helpers.toy_rig import toy_rig
from helpers.waiting import ended
from limits import RateLimitItemPerMinute
from werkzeug.security import generate_password_hash

from breastrig.api import share_limits
from breastrig.api.access import rate_limits
from breastrig.api.access.session import COOKIE as SESSION_COOKIE
from breastrig.api.app_context import KEY, AppContext
from breastrig.api.config import Config
from breastrig.api.routes.shares import share_credential
from breastrig.api.routes.shares import share_credential as passcode_module
from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.scan.read import read_scan
from breastrig.service.service import Service
from breastrig.storage.documents.shares import note_wrong_passcode

pytestmark = pytest.mark.long

TOKEN = "a-token-of-more-than-sixteen-characters"
FILES = ("result.json", "fitted.glb", "fitted.ply", "drawing.json", "plan.json")


@pytest.fixture
def visitor(client_for: Callable[[Config], FlaskClient], config: Config) -> FlaskClient:
    """A browser that has no token; the service has one."""
    return client_for(replace(config, host="0.0.0.0", token=TOKEN))


@pytest.fixture(scope="module")
def lasting_fit(app: APIFlask, service: Service, torso: bytes) -> Iterator[str]:
    """A fit that is done, for tests that neither change nor delete it."""
    client = app.test_client()
    scan = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json
    fit = client.post("/api/fits", json={"scan": scan["id"], "drawing": "lumpectomy"}).json["id"]
    assert ended(service, fit).state == "done"
    yield fit
    client.delete(scan["links"]["self"])


@pytest.fixture
def share(client: FlaskClient, request: pytest.FixtureRequest) -> Callable[..., dict]:
    """Makes a share of a done fit, the test's own where it has one; the answer with the secret as `token`."""
    has_own = {"fit_id", "scan_id"} & set(request.fixturenames)
    fit = request.getfixturevalue("fit_id" if has_own else "lasting_fit")

    def make(**wishes: object) -> dict:
        answer = client.post(f"/api/fits/{fit}/shares", json=wishes)
        assert answer.status_code == 201, answer.json
        assert answer.headers["Location"] == answer.json["links"]["self"]
        return answer.json | {"token": answer.json["url"].removeprefix("/s#")}

    return make


def context_of(visitor: FlaskClient) -> AppContext:
    return visitor.application.extensions[KEY]


def opened(visitor: FlaskClient, made: dict, **more: str):
    return visitor.post("/api/shared/open", json={"token": made["token"], **more})


def test_a_link_shows_the_result_and_by_default_not_the_scan(
    client: FlaskClient, visitor: FlaskClient, service: Service, fit_id: str, share
) -> None:
    made = share()
    assert len(made["token"]) == 32
    left = datetime.fromisoformat(made["expires_at"]) - datetime.now(UTC)
    assert timedelta(days=6.99) < left < timedelta(days=7)
    answer = opened(visitor, made)
    assert answer.status_code == 200
    place = f"/api/shared/{made['id']}"
    assert answer.json == {
        "id": made["id"],
        "expires_at": made["expires_at"],
        "shown_at": made["shown_at"],
        "links": {
            "self": place,
            "result": f"{place}/result.json",
            "fitted_glb": f"{place}/fitted.glb",
            "fitted_ply": f"{place}/fitted.ply",
            "drawing": f"{place}/drawing.json",
            "distances": None,
            "plan": f"{place}/plan.json",
            "report": None,
            "mesh": None,
            "close": f"{place}/close",
        },
    }
    assert visitor.get(place).json == answer.json
    for name in FILES:
        found = visitor.get(f"{place}/{name}")
        assert found.data == (shown_files(service, made["id"]) / name).read_bytes()
        assert found.headers["Cache-Control"] == "no-store"
        assert "Cookie" in found.vary
        assert fit_id.encode() not in found.data  # ids are the owner's
    for name in ("mesh.glb", "report.pdf", "distances.bin"):
        assert "does not show the scan" in problem(visitor.get(f"{place}/{name}"), 403)


def fitted(client: FlaskClient, service: Service, scan_id: str) -> str:
    """A refined fit: its fake has a layer 3 mm before the model."""
    picked = {"nipple_L": [70.0, 350.0, 120.0]}
    asked = {"scan": scan_id, "refine": True, "landmarks": picked}
    fit = client.post("/api/fits", json=asked).json["id"]
    assert ended(service, fit).state == "done"
    return fit


def share_of(client: FlaskClient, fit: str, **wishes: object) -> dict:
    made = client.post(f"/api/fits/{fit}/shares", json=wishes)
    assert made.status_code == 201, made.json
    return made.json | {"token": made.json["url"].removeprefix("/s#")}


def vertices_of(content: bytes) -> np.ndarray:
    """(V, 3) m of a PLY in metres."""
    return read_scan(content, "ply", "m", texture=False).vertices


def test_a_link_without_the_scan_gives_the_model_alone(
    client: FlaskClient, visitor: FlaskClient, service: Service, scan_id: str
) -> None:
    fit = fitted(client, service, scan_id)
    alone = fake_fit.surface(refined=False)
    links = opened(visitor, share_of(client, fit)).json["links"]
    np.testing.assert_allclose(vertices_of(visitor.get(links["fitted_ply"]).data), alone, atol=1e-6)
    document, _ = split_glb(visitor.get(links["fitted_glb"]).data)
    names = [name for mesh in document["meshes"] for name in mesh.get("extras", {}).get("targetNames", ())]
    assert len(names) == len(toy_rig().shapes), "no skin layer"
    result, owners = visitor.get(links["result"]).json, client.get(f"/api/fits/{fit}/result.json").json
    given = {"landmarks_given", "marks_given", "certain", "confidence"}
    assert set(owners) - set(result) == {"areolae", "model_alone", *given}
    assert (result["refined"], result["landmarks_picked"], result["scan"]["sha256"]) == (False, {}, "")
    assert result["surface_distance_mm"] == owners["model_alone"]["surface_distance_mm"]
    assert result["parameters"] == owners["parameters"]
    model = toy_rig().landmark_points().positions(alone, toy_rig().faces)
    for name, place in zip(toy_rig().landmark_names, model, strict=True):
        np.testing.assert_allclose(result["landmarks"][name], place, atol=1e-6)
    [line] = visitor.get(links["drawing"]).json["shapes"]
    points = 1e-3 * np.array(line["points"])
    assert np.linalg.norm(points - 1e-3 * np.array(fake_fit.DRAWN["points"]), axis=1).min() > 0.01
    on_model = ClosestPointSearch(alone, toy_rig().faces).query(points)
    assert on_model.distances.max() < 1e-6, "lines lie on the model, not on her skin"


def test_a_link_with_the_scan_shows_the_layer_and_distances_but_not_where_skin_was_cut_away(
    client: FlaskClient, visitor: FlaskClient, service: Service, scan_id: str
) -> None:
    fit = fitted(client, service, scan_id)
    alone, refined = (fake_fit.surface(refined) for refined in (False, True))
    client.put(f"/api/scans/{scan_id}/cuts", json={"cuts": [LOWER]})
    links = opened(visitor, share_of(client, fit, scan="plain")).json["links"]
    cut = refined[:, 1] < 0.2
    assert 0 < np.count_nonzero(cut) < len(cut)
    shown = vertices_of(visitor.get(links["fitted_ply"]).data)
    np.testing.assert_allclose(shown, np.where(cut[:, None], alone, refined), atol=1e-6)
    distances = np.frombuffer(visitor.get(links["distances"]).data, "<f4")
    assert (np.isnan(distances) == cut).all()
    assert (distances[~cut] == 0.25).all()
    assert links["report"] is None, "this fake has too little for one"
    problem(visitor.get(links["self"] + "/report.pdf"), 404)


LOWER = {"to_picture": np.eye(4).ravel().tolist(), "lasso": [[-9.0, -9.0], [9.0, -9.0], [9.0, 0.2], [-9.0, 0.2]]}


@pytest.mark.slow
@pytest.mark.parametrize("scan", ["plain", "full"])
def test_the_scan_is_shown_when_the_owner_says_so_as_it_is_visible(
    client: FlaskClient, visitor: FlaskClient, scan_id: str, share, scan: str
) -> None:
    assert client.put(f"/api/scans/{scan_id}/cuts", json={"cuts": [LOWER]}).status_code == 200
    made = share(scan=scan)
    answer = visitor.get(opened(visitor, made).json["links"]["mesh"])
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["Content-Disposition"] == "attachment; filename=scan.glb"
    whole, shown = (triangles_of(glb) for glb in (client.get(f"/api/scans/{scan_id}/mesh.glb").data, answer.data))
    kept = whole[whole.mean(axis=1)[:, 1] > 0.2]
    assert 0 < len(kept) < len(whole)
    assert sorted(map(tuple, shown.mean(axis=1).round(4))) == sorted(map(tuple, kept.mean(axis=1).round(4)))


def triangles_of(glb: bytes) -> np.ndarray:
    """(F, 3, 3) m; every vertex is of one."""
    document, binary = split_glb(glb)
    arrays, primitive = GltfArrays(document, binary), document["meshes"][0]["primitives"][0]
    vertices = arrays.read(primitive["attributes"]["POSITION"]) + document["nodes"][0].get("translation", np.zeros(3))
    faces = arrays.read(primitive["indices"]).reshape(-1, 3)
    assert len(np.unique(faces)) == len(vertices)
    return vertices[faces]


@pytest.mark.slow
def test_a_visitors_day(client: FlaskClient, visitor: FlaskClient, service: Service, scan_id: str, fit_id: str) -> None:
    """A link shows what stood when it was made, until its owner refreshes it, and nothing once it is over."""
    scan = client.get(f"/api/scans/{scan_id}").json
    plan, cuts, patient = scan["links"]["plan"], scan["links"]["cuts"], scan["links"]["patient"]
    line = {"kind": "line", "id": "a", "scan": scan_id, "name": "first", "points": [[0, 300, 130], [20, 300, 128]]}
    note = {"kind": "note", "id": "n", "scan": scan_id, "text": "Mrs Example wants it smaller", "point": [0, 350, 130]}

    def planned(*items: dict) -> None:
        seen = client.get(plan).headers["ETag"]
        assert client.put(plan, json={"items": list(items)}, headers={"If-Match": seen}).status_code == 200

    def seen_by_visitor(links: dict) -> dict[str, bytes]:
        return {name: visitor.get(link).data for name, link in links.items() if link and name not in ("self", "close")}

    planned(line, note)
    silent, telling = (share_of(client, fit_id, scan="plain", notes=notes) for notes in (False, True))
    alone = share_of(client, fit_id)
    links = {made["id"]: opened(visitor, made).json["links"] for made in (silent, telling, alone)}
    first = {share: seen_by_visitor(each) for share, each in links.items()}
    assert [silent["notes"], telling["notes"]] == [False, True]
    assert {share: b"Mrs Example" in b"".join(files.values()) for share, files in first.items()} == {
        silent["id"]: False,
        telling["id"]: True,
        alone["id"]: False,
    }
    for files in first.values():
        assert [shape["name"] for shape in json.loads(files["plan"])["shapes"] if shape["kind"] == "line"] == ["first"]
        assert scan_id.encode() not in b"".join(files.values())
        assert fit_id.encode() not in b"".join(files.values())

    planned(line | {"name": "second"}, note | {"text": "Mrs Example said otherwise"})
    client.put(cuts, json={"cuts": [LOWER]})
    assert {share: seen_by_visitor(each) for share, each in links.items()} == first, "nobody refreshed it"
    for made in (silent, telling, alone):
        assert client.get(made["links"]["self"]).json["shown_at"] == made["shown_at"]

    refreshed = client.post(silent["links"]["refresh"]).json
    assert refreshed["shown_at"] > silent["shown_at"]
    now = seen_by_visitor(links[silent["id"]])
    assert b"second" in now["plan"]
    assert b"first" not in now["plan"] + now["drawing"] + now["fitted_glb"]
    assert b"Mrs Example" not in b"".join(now.values())
    assert triangles_of(now["mesh"])[:, :, 1].mean(axis=1).min() > 0.2
    assert visitor.get(links[silent["id"]]["self"]).json["shown_at"] == refreshed["shown_at"]
    assert {one: seen_by_visitor(links[one]) for one in (telling["id"], alone["id"])} == {
        one: first[one] for one in (telling["id"], alone["id"])
    }
    folders = {made["id"]: shown_files(service, made["id"]) for made in (silent, telling, alone)}
    assert all(folder.is_dir() for folder in folders.values())

    assert client.delete(silent["links"]["self"]).status_code == 204
    problem(visitor.get(links[silent["id"]]["plan"]), 410)
    assert not folders[silent["id"]].exists()
    problem(client.post(silent["links"]["refresh"]), 409)
    expire(service, alone["id"])
    service.shares.end_expired()
    assert not folders[alone["id"]].exists()
    problem(visitor.get(links[alone["id"]]["plan"]), 410)
    assert folders[telling["id"]].exists()
    assert client.delete(patient).status_code == 204
    problem(visitor.get(links[telling["id"]]["plan"]), 401)
    assert not folders[telling["id"]].exists()
    assert b"Mrs Example" not in bytes_below(service.storage.root)


@pytest.mark.slow
def test_a_link_that_cannot_be_made_leaves_nothing(
    client: FlaskClient, service: Service, scan_id: str, fit_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    everything = {"to_picture": np.eye(4).ravel().tolist(), "lasso": [[-9, -9], [9, -9], [9, 9], [-9, 9]]}
    client.put(f"/api/scans/{scan_id}/cuts", json={"cuts": [everything]})
    kept = set(service.storage.root.rglob("shown-*"))
    assert "nothing to look at" in problem(client.post(f"/api/fits/{fit_id}/shares", json={"scan": "plain"}), 422)
    client.put(f"/api/scans/{scan_id}/cuts", json={"cuts": []})
    result = service.shares._processes.result

    def late(*given: object) -> object:
        made = result(*given)
        client.application.test_client().delete(f"/api/scans/{scan_id}")
        return made

    monkeypatch.setattr(service.shares._processes, "result", late)
    problem(client.post(f"/api/fits/{fit_id}/shares", json={"scan": "plain"}), 404)
    assert set(service.storage.root.rglob("shown-*")) == kept
    assert list((service.storage.root / "incoming").iterdir()) == []


@pytest.mark.slow
def test_the_cookie_goes_to_its_own_share_only_ends_with_the_browser_and_scripts_cannot_read_it(
    visitor: FlaskClient, share
) -> None:
    made = share()
    cookie, listed = opened(visitor, made).headers.getlist("Set-Cookie")
    assert cookie.startswith(f"breastrig_share_{made['id']}=")
    assert f"Path=/api/shared/{made['id']}" in cookie.split("; ")
    assert "Path=/api/shared/open" in listed.split("; ")
    for each in (cookie, listed):
        assert {"HttpOnly", "SameSite=Strict"} < set(each.split("; "))
        assert "Max-Age" not in each
        assert "Expires" not in each
        assert made["token"] not in each
    assert "Secure" in visitor.post(
        "/api/shared/open", json={"token": made["token"]}, base_url="https://scans.example"
    ).headers["Set-Cookie"].split("; ")


def cookie_of(visitor: FlaskClient, made: dict) -> str:
    """The credential that the browser has of a share."""
    name, path = share_credential.cookie_name(made["id"]), share_credential.cookie_path(made["id"])
    cookie = visitor.get_cookie(name, path=path)
    assert cookie is not None
    return cookie.value


def thief_of(visitor: FlaskClient) -> FlaskClient:
    """Sends the cookies that a test writes into its headers, whatever their paths."""
    return visitor.application.test_client(use_cookies=False)


def with_cookie(made: dict, value: str) -> dict[str, str]:
    """Headers that bring the value as a share's credential."""
    return {"Cookie": f"{share_credential.cookie_name(made['id'])}={value}"}


@pytest.mark.slow
def test_two_links_open_in_one_browser_show_each_its_own(
    client: FlaskClient, visitor: FlaskClient, service: Service, fit_id: str, share
) -> None:
    """Both are of the same patient here; the fits differ in their files."""
    other = client.post("/api/fits", json={"scan": client.get(f"/api/fits/{fit_id}").json["scan"]}).json["id"]
    assert ended(service, other).state == "done"
    made = {fit_id: share(), other: client.post(f"/api/fits/{other}/shares", json={}).json}
    made[other]["token"] = made[other]["url"].removeprefix("/s#")
    shown = {fit: opened(visitor, one).json["links"] for fit, one in made.items()}
    for fit, content in ((fit_id, b"the first's"), (other, b"the second's")):
        (shown_files(service, made[fit]["id"]) / "fitted.ply").write_bytes(content)
    for _ in range(3):
        assert visitor.get(shown[fit_id]["fitted_ply"]).data == b"the first's"
        assert visitor.get(shown[other]["fitted_ply"]).data == b"the second's"


@pytest.mark.slow
def test_a_credential_of_one_share_opens_nothing_of_another(visitor: FlaskClient, share) -> None:
    mine, others = share(), share()
    opened(visitor, mine)
    value = cookie_of(visitor, mine)
    thief = thief_of(visitor)
    links = [f"/api/shared/{others['id']}{name}" for name in ("", *(f"/{name}" for name in FILES), "/mesh.glb")]
    for link in links:
        for headers in (
            with_cookie(others, value),
            with_cookie(mine, value),
            with_cookie(others, value) | {"X-Forwarded-For": "127.0.0.1"},
            with_cookie(others, mine["token"]),
            with_cookie(others, others["token"]),
            with_cookie(others, ""),
            with_cookie(others, "é"),
        ):
            problem(thief.get(link, headers=headers), 401)
        problem(visitor.get(link), 401)
    problem(thief.post(f"{links[0]}/close", headers=with_cookie(others, value)), 401)
    for made_up in ("open", "nobody", "x" * 1000, "%00", "%ED%A0%80"):
        answer = thief.get(f"/api/shared/{made_up}", headers=with_cookie(mine, value))
        problem(answer, 404 if len(made_up) > 100 else 401)
    assert thief.get(f"/api/shared/{mine['id']}", headers=with_cookie(mine, value)).status_code == 200


@pytest.mark.slow
def test_closing_ends_the_credential_for_every_copy_of_it_and_signs_nobody_out(visitor: FlaskClient, share) -> None:
    visitor.post("/sign-in", data={"token": TOKEN})
    made, other = share(), share()
    for one in (made, other):
        opened(visitor, one)
    value, place = cookie_of(visitor, made), f"/api/shared/{made['id']}"
    thief = thief_of(visitor)
    assert thief.get(place, headers=with_cookie(made, value)).status_code == 200
    problem(thief.post(f"{place}/close"), 401)
    problem(visitor.post(f"{place}/close", headers={"Origin": "http://evil.example"}), 403)
    closed = visitor.post(f"{place}/close")
    assert (closed.status_code, closed.data) == (204, b"")
    assert closed.headers["Clear-Site-Data"] == '"cache"'  # "cookies" or "storage" would be the owner's too
    assert visitor.get_cookie(share_credential.cookie_name(made["id"]), path=place) is None
    problem(visitor.get(place), 401)
    problem(thief.get(place, headers=with_cookie(made, value)), 401)
    problem(thief.post(f"{place}/close", headers=with_cookie(made, value)), 401)
    assert visitor.get(f"/api/shared/{other['id']}").status_code == 200
    assert visitor.get_cookie(SESSION_COOKIE) is not None
    assert visitor.get("/api/meta").status_code == 200
    assert opened(visitor, made).status_code == 200  # the link itself is as it was


def test_a_link_that_is_opened_again_leaves_no_earlier_credential(visitor: FlaskClient, share) -> None:
    made = share()
    opened(visitor, made)
    earlier = cookie_of(visitor, made)
    opened(visitor, made)
    place = f"/api/shared/{made['id']}"
    assert visitor.get(place).status_code == 200
    fresh = thief_of(visitor)
    problem(fresh.get(place, headers=with_cookie(made, earlier)), 401)


@pytest.mark.slow
def test_a_visit_ends_after_a_working_day(visitor: FlaskClient, share, monkeypatch: pytest.MonkeyPatch) -> None:
    made = share()
    opened(visitor, made)
    monkeypatch.setattr(share_credential, "VISIT_S", 0)
    assert "open it again" in problem(visitor.get(f"/api/shared/{made['id']}"), 401)


@pytest.mark.slow
def test_a_browser_keeps_the_last_links_it_opened_the_oldest_ends_and_no_request_carries_more_for_them(
    visitor: FlaskClient, share
) -> None:
    most = share_limits.COOKIES
    made, values = [share() for _ in range(most + 2)], []
    for one in made:
        opened(visitor, one)
        values.append(cookie_of(visitor, one))
    kept = [name for name in visitor._cookies if "breastrig_share_" in str(name)]
    assert len(kept) == most
    sent = visitor.get(f"/api/shared/{made[-1]['id']}").request.headers["Cookie"]
    assert sent.count("=") == 1
    assert len(sent) < 150
    listed = visitor.get_cookie(share_credential.OPENED_COOKIE, path=share_credential.OPENED_PATH)
    assert listed is not None
    assert len(listed.value) < 2000
    for one, value, status in zip(made, values, [401] * 2 + [200] * most, strict=True):
        place = f"/api/shared/{one['id']}"
        assert visitor.get(place).status_code == status
        fresh = thief_of(visitor)
        assert fresh.get(place, headers=with_cookie(one, value)).status_code == status


def test_a_made_up_list_of_open_links_does_no_harm(visitor: FlaskClient, share) -> None:
    made, other = share(), share()
    opened(visitor, other)
    for listed in ("", "x", "nobody=" + "0" * 64, "a=b.c=d", "\x7f" * 3000, ".".join(["a=" + "f" * 64] * 99)):
        answer = thief_of(visitor).post(
            "/api/shared/open",
            json={"token": made["token"]},
            headers={"Cookie": f"{share_credential.OPENED_COOKIE}={listed}"},
        )
        assert answer.status_code == 200
        for cookie in answer.headers.getlist("Set-Cookie"):
            assert cookie.startswith(("breastrig_share_", "breastrig_opened="))
    assert visitor.get(f"/api/shared/{other['id']}").status_code == 200


@pytest.mark.slow
def test_an_ended_link_opens_nothing_and_says_why(
    client: FlaskClient, visitor: FlaskClient, service: Service, share
) -> None:
    revoked, expired = share(), share()
    for _ in range(2):
        assert client.delete(revoked["links"]["self"]).status_code == 204
    expire(service, expired["id"])
    for made in (revoked, expired):
        assert "expired or was revoked" in problem(opened(visitor, made), 410)
        assert client.get(made["links"]["self"]).json["is_open"] is False
    assert client.get(revoked["links"]["self"]).json["revoked_at"] is not None
    for token in ("x", "x" * 100, revoked["id"], "é"):
        assert "opens nothing" in problem(visitor.post("/api/shared/open", json={"token": token}), 404)


@pytest.mark.slow
def test_a_link_whose_secret_was_lost_with_the_index_is_over_and_its_owner_sees_that(
    client: FlaskClient, visitor: FlaskClient, lose_index, fit_id: str, share
) -> None:
    made = share()
    assert opened(visitor, made).status_code == 200
    lose_index()
    problem(visitor.get(f"/api/shared/{made['id']}/result.json"), 401)
    problem(opened(visitor, made), 404)
    [listed] = client.get(f"/api/fits/{fit_id}/shares").json["shares"]
    assert (listed["id"], listed["is_open"]) == (made["id"], False)
    problem(client.post(made["links"]["refresh"]), 409)
    assert client.delete(made["links"]["self"]).status_code == 204
    again = share()
    assert opened(visitor, again).status_code == 200


def test_a_passcode_is_asked_for_and_cannot_be_got_round(client: FlaskClient, visitor: FlaskClient, share) -> None:
    made = share(passcode="4711 please")
    assert made["has_passcode"]
    assert "needs a passcode" in problem(opened(visitor, made), 403)
    assert "not the link's passcode" in problem(opened(visitor, made, passcode="4711"), 403)
    place = f"/api/shared/{made['id']}"
    problem(thief_of(visitor).get(place, headers=with_cookie(made, made["token"])), 401)
    assert client.get(made["links"]["self"]).json["openings"] == 0
    assert opened(visitor, made, passcode="4711 please").status_code == 200
    assert visitor.get(f"{place}/result.json").status_code == 200


def set_passcode(service: Service, made: dict, passcode: str) -> None:
    """One that is checked quickly, or that new links do not take."""
    quick = generate_password_hash(passcode, "pbkdf2:sha256:1")
    with service.storage.index.writing() as rows:
        rows.execute("UPDATE link_secrets SET passcode_hash = ? WHERE link = ?", (quick, made["id"]))


def guess(visitor: FlaskClient, made: dict, passcode: str, address: str = "127.0.0.1"):
    return visitor.post(
        "/api/shared/open",
        json={"token": made["token"], "passcode": passcode},
        environ_base={"REMOTE_ADDR": address},
    )


@pytest.mark.slow
def test_wrong_passcodes_keep_the_one_who_guesses_waiting_and_nobody_else(
    visitor: FlaskClient, service: Service, share, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, other, moment = share(passcode="the right one"), share(passcode="another one"), [1000.0]
    set_passcode(service, made, "the right one")
    set_passcode(service, other, "another one")
    monkeypatch.setattr(context_of(visitor).passcode_delays, "_clock", lambda: moment[0])
    waits = []
    for number in range(12):
        problem(guess(visitor, made, "a wrong one", "10.0.0.9"), 403)
        if number + 1 < share_limits.FREE_GUESSES:
            continue
        answer = guess(visitor, made, "the right one", "10.0.0.9")
        assert "wrong passcodes" in problem(answer, 429)
        waits.append(int(answer.headers["Retry-After"]))
        assert guess(visitor, made, "the right one", "10.0.0.10").status_code == 200
        assert guess(visitor, other, "another one", "10.0.0.9").status_code == 200
        moment[0] += waits[-1]
    assert waits == [1, 2, 4, 8, 16, 32, 60, 60, 60, 60]
    assert guess(visitor, made, "the right one", "10.0.0.9").status_code == 200
    problem(guess(visitor, made, "a wrong one", "10.0.0.9"), 403)
    assert guess(visitor, made, "the right one", "10.0.0.9").status_code == 200  # as good as new after a right one


@pytest.mark.slow
def test_the_addresses_of_one_house_wait_for_each_others_wrong_passcodes(
    visitor: FlaskClient, share, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = share(passcode="the right one")
    monkeypatch.setattr(context_of(visitor).passcode_delays, "_clock", lambda: 1000.0)  # however slow the machine
    for number in range(share_limits.FREE_GUESSES):
        problem(guess(visitor, made, "a wrong one", f"2001:db8:1:2::{number}"), 403)
    assert "wrong passcodes" in problem(guess(visitor, made, "the right one", "2001:db8:1:2:ffff::9"), 429)
    assert guess(visitor, made, "the right one", "2001:db8:1:3::9").status_code == 200


@pytest.mark.slow
def test_guessing_from_everywhere_locks_out_nobody_until_the_link_is_locked_and_its_owner_sees_and_unlocks_it(
    client: FlaskClient, visitor: FlaskClient, service: Service, client_for, config: Config, share
) -> None:
    made = share(passcode="the right one")
    set_passcode(service, made, "the right one")
    inside = client_for(replace(config, host="0.0.0.0", token=TOKEN))
    assert guess(inside, made, "the right one").status_code == 200
    for number in range(share_limits.WRONG_PASSCODES):
        if number in (10, share_limits.WRONG_PASSCODES - 1):
            assert guess(visitor, made, "the right one", "10.9.9.9").status_code == 200
        problem(guess(visitor, made, f"wrong one {number}", f"10.0.{number // 250}.{number % 250}"), 403)
    for passcode, address in (
        ("wrong again", "10.1.0.1"),
        ("the right one", "10.9.9.9"),
        ("the right one", "10.8.0.1"),
    ):
        assert "unlock" in problem(guess(visitor, made, passcode, address), 423)
    assert "unlock" in problem(opened(visitor, made), 423)  # no passcode is asked for that would not be looked at
    assert inside.get(f"/api/shared/{made['id']}").status_code == 200  # whoever has given it goes on
    seen = client.get(made["links"]["self"]).json
    assert (seen["is_open"], seen["is_locked"], seen["wrong_passcodes"]) == (False, True, share_limits.WRONG_PASSCODES)
    assert seen["created_at"] < seen["last_wrong_passcode_at"]
    unlocked = client.post(seen["links"]["unlock"]).json
    assert (unlocked["is_open"], unlocked["is_locked"]) == (True, False)
    assert unlocked["wrong_passcodes"] == share_limits.WRONG_PASSCODES
    problem(guess(visitor, made, "wrong again", "10.1.0.2"), 403)
    assert guess(visitor, made, "the right one", "10.9.9.9").status_code == 200
    problem(client.post(seen["links"]["unlock"].replace(made["id"], "nobody")), 404)


@pytest.mark.slow
def test_guesses_that_are_checked_at_the_same_time_are_no_more_than_the_limit(
    client: FlaskClient, visitor: FlaskClient, service: Service, share, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The link is locked between the looking and the answer: then a right guess cannot be told from a wrong one."""
    answers = []
    for is_right in (True, False):
        made = share(passcode="the right one")

        def others_guess(_hash: str, _passcode: str, made: dict = made, is_right: bool = is_right) -> bool:
            for _ in range(share_limits.WRONG_PASSCODES + 5):
                note_wrong_passcode(service.storage, made["id"], "2026", share_limits.WRONG_PASSCODES)
            return is_right

        with monkeypatch.context() as meanwhile:
            meanwhile.setattr(passcode_module, "check_password_hash", others_guess)
            answer = guess(visitor, made, "a guess")
        problem(answer, 423)
        assert "Set-Cookie" not in answer.headers
        answers.append((answer.data, dict(answer.headers)))
        seen = client.get(made["links"]["self"]).json
        assert (seen["wrong_passcodes"], seen["openings"]) == (share_limits.WRONG_PASSCODES, 0)
    assert answers[0] == answers[1]


def test_the_chance_to_guess_a_passcode_before_the_link_is_locked() -> None:
    """Digits chosen at random: the numbers in share_limits' docstring."""
    assert pytest.approx(1e-4) == share_limits.WRONG_PASSCODES / 10**share_limits.PASSCODE_LENGTH
    assert pytest.approx(1e-2) == share_limits.WRONG_PASSCODES / 10**4


@pytest.mark.slow
def test_a_passcode_that_an_older_version_allowed_still_opens_its_link(
    client: FlaskClient, visitor: FlaskClient, service: Service, share
) -> None:
    made = share(passcode="123456")
    set_passcode(service, made, "4711")
    assert guess(visitor, made, "4711").status_code == 200


def test_opening_is_slowed_down(visitor: FlaskClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(rate_limits.PER_MINUTE, "share", RateLimitItemPerMinute(3))
    codes = [visitor.post("/api/shared/open", json={"token": "x"}).status_code for _ in range(4)]
    assert codes == [404, 404, 404, 429]


def test_the_owner_sees_when_a_link_was_opened_and_nothing_about_whom(
    client: FlaskClient, visitor: FlaskClient, fit_id: str, share
) -> None:
    made = share()
    for _ in range(3):
        opened(visitor, made)
    seen = client.get(made["links"]["self"]).json
    assert seen["openings"] == len(seen["opened_at"]) == 3
    assert seen["last_opened_at"] == seen["opened_at"][0] == max(seen["opened_at"])
    assert "url" not in seen
    assert set(seen) == {
        *("id", "created_at", "expires_at", "revoked_at", "is_open", "is_locked", "scan", "notes"),
        *("has_passcode", "shown_at"),
        *("openings", "last_opened_at", "opened_at", "wrong_passcodes", "last_wrong_passcode_at", "links"),
    }


def test_shares_are_listed_page_by_page(client: FlaskClient, fit_id: str, share) -> None:
    made = [share()["id"] for _ in range(3)]
    address = client.get(f"/api/fits/{fit_id}").json["links"]["shares"]
    assert [one["id"] for one in client.get(address).json["shares"]] == made[::-1]
    found, address = [], f"{address}?limit=2"
    while address:
        page = client.get(address).json
        found += [one["id"] for one in page["shares"]]
        address = page["next"]
    assert found == made[::-1]


@pytest.mark.slow
def test_only_hashes_of_secrets_are_stored_and_delete_removes_them(
    client: FlaskClient, visitor: FlaskClient, service: Service, scan_id: str, share
) -> None:
    made = share(passcode="xylophone-17")
    opened(visitor, made, passcode="xylophone-17")
    kept = bytes_below(service.storage.root)
    value = cookie_of(visitor, made)
    for secret in (made["token"], value, hashlib.sha256(value.encode()).hexdigest()):
        assert secret.encode() not in kept
    assert b"xylophone" not in kept
    assert made["id"].encode() in kept
    client.delete(f"/api/scans/{scan_id}")
    left = bytes_below(service.storage.root)
    assert made["id"].encode() not in kept_below(service.storage.root)
    assert share_credential.token_sha256(made["token"]).encode() not in left
    problem(visitor.get(f"/api/shared/{made['id']}/result.json"), 401)


def test_a_share_that_cannot_be_meant_is_refused(client: FlaskClient, fit_id: str) -> None:
    for wish in (
        {"expires_in_days": 0},
        {"expires_in_days": 91},
        {"passcode": "12345"},
        {"scan": "some"},
        {"fit": "x"},
    ):
        problem(client.post(f"/api/fits/{fit_id}/shares", json=wish), 422)


def test_only_results_are_shared(client: FlaskClient, scan_id: str) -> None:
    problem(client.post("/api/fits/nobody/shares", json={}), 404)
    problem(client.get("/api/fits/nobody/shares"), 404)
    problem(client.get("/api/fits/nobody/shares/nobody"), 404)
    assert client.delete("/api/fits/nobody/shares/nobody").status_code == 204
    running = client.post("/api/fits", json={"scan": scan_id, "preset": "paper", "drawing": None}).json
    assert "no result to share" in problem(client.post(running["links"]["shares"], json={}), 409)
    client.post(running["links"]["cancel"])


@pytest.mark.parametrize("place", ["/s", "/s/a-share"])
def test_the_page_of_a_link_holds_nothing_by_itself(visitor: FlaskClient, place: str) -> None:
    answer = visitor.get(place)
    assert (answer.status_code, answer.headers["Cache-Control"]) == (200, "no-store")
    html = answer.get_data(as_text=True)
    assert "<script>" not in html
    assert 'style="' not in html
    for place in re.findall(r'(?:src|href)="([^"]+)"', html):
        assert place.startswith("/")
        assert visitor.get(place).status_code == 200
    assert visitor.get("/s/share.js").mimetype == "text/javascript"
    assert answer.headers["Referrer-Policy"] == "no-referrer"
