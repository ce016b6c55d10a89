"""Sign-in at a real provider of OpenID Connect, a process of its own."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import timedelta
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from flask.testing import FlaskClient
from helpers.openid_provider import CLIENT, PASSWORD, SECRET, openid_provider
from helpers.problems import problem

from breastrig.api.access import session
from breastrig.api.config import Config
from breastrig.api.people.people import People
from breastrig.core import wall_clock

CALLBACK = "http://localhost/sign-in/callback"
TOKEN = "a-token-of-more-than-sixteen-characters"
COOKIE = "breastrig_session"

pytestmark = [pytest.mark.slow]


@pytest.fixture(scope="module")
def issuer() -> Iterator[str]:
    with openid_provider(CALLBACK) as issuer:
        yield issuer


@pytest.fixture(scope="module")
def people(issuer: str) -> People:
    return People.model_validate(
        {
            "issuer": issuer,
            "client_id": CLIENT,
            "client_secret": SECRET,
            "scopes": ["openid", "profile", "groups"],
            "groups": {
                "north": {"claim": "clinic-north", "role": "plan"},
                "south": {"claim": "clinic-south", "role": "administer"},
                "readers": {"claim": "clinic-north-readers", "role": "look"},
                "clinic-ward": {},
            },
        }
    )


@pytest.fixture
def browser(client_for: Callable[[Config], FlaskClient], config: Config, people: People) -> FlaskClient:
    return client_for(replace(config, host="0.0.0.0", token=TOKEN, people=people))


def at_provider(address: str, name: str, password: str = PASSWORD) -> str:
    """Where the provider sends a browser whose person signs in there."""
    with httpx.Client(follow_redirects=False, trust_env=False) as visitor:
        answer = visitor.get(address)
        for _ in range(12):
            if answer.is_redirect:
                place = str(answer.next_request.url) if answer.next_request else ""
                if place.startswith(CALLBACK):
                    return place
                answer = visitor.get(place)
                continue
            form = dict(re.findall(r'<input[^>]*name="([^"]+)"[^>]*value="([^"]*)"', answer.text))
            fields = re.findall(r'name="(login|password)"', answer.text)
            assert fields, answer.text[:3000]
            form |= {"login": name} if "login" in fields else {"password": password}
            answer = visitor.post(str(answer.url), data=form)
            if answer.status_code == 200 and "password" in fields:
                return ""  # refused
    raise AssertionError("the provider goes round in circles")


def begin(browser: FlaskClient) -> str:
    answer = browser.get("/sign-in/start")
    assert (answer.status_code, answer.headers["Cache-Control"]) == (302, "no-store")
    return answer.headers["Location"]


def come_back(browser: FlaskClient, place: str):
    parts = urlsplit(place)
    return browser.get(f"{parts.path}?{parts.query}", headers={"Sec-Fetch-Site": "cross-site"})


def sign_in(browser: FlaskClient, name: str):
    return come_back(browser, at_provider(begin(browser), name))


def test_a_person_signs_in_with_code_pkce_state_and_nonce(browser: FlaskClient, issuer: str) -> None:
    first = browser.get("/")
    assert (first.status_code, first.headers["Location"]) == (303, "/sign-in")
    page = browser.get("/sign-in").get_data(as_text=True)
    assert ('href="/sign-in/start"' in page, 'type="password"' in page) == (True, False)
    address = begin(browser)
    asked = {name: value for name, [value] in parse_qs(urlsplit(address).query).items()}
    assert address.startswith(f"{issuer}/")
    assert {name: asked[name] for name in ("response_type", "client_id", "redirect_uri", "prompt")} == {
        "response_type": "code", "client_id": CLIENT, "redirect_uri": CALLBACK, "prompt": "login",
    }  # fmt: skip
    assert (asked["code_challenge_method"], len(asked["code_challenge"])) == ("S256", 43)
    assert min(len(asked["state"]), len(asked["nonce"])) >= 20
    [waiting] = [cookie for cookie in browser._cookies.values() if cookie.key.startswith("breastrig_sign_in_")]
    assert (waiting.http_only, waiting.same_site, waiting.path) == (True, "Lax", "/sign-in")
    answer = come_back(browser, at_provider(address, "anna"))
    assert (answer.status_code, answer.headers["Location"], answer.headers["Cache-Control"]) == (303, "/", "no-store")
    [cookie] = [one for one in answer.headers.getlist("Set-Cookie") if one.startswith(f"{COOKIE}=")]
    assert ("HttpOnly" in cookie, "SameSite=Strict" in cookie, "Path=/;" in cookie) == (True, True, True)
    assert not any(one.key.startswith("breastrig_sign_in_") for one in browser._cookies.values())
    person = browser.get("/api/meta").json["person"]
    assert person.pop("id") == "anna"
    assert person == {"name": "Anna", "role": "plan", "groups": ["north"], "all_groups": [], "idle_minutes": 15}
    assert b"You are signed in. (Anna" in browser.get("/sign-in").data


def test_the_cookie_is_sent_over_tls_alone_where_there_is_tls(browser: FlaskClient) -> None:
    answer = browser.get("/sign-in/start", base_url="https://localhost")
    assert "Secure" in next(one for one in answer.headers.getlist("Set-Cookie") if "breastrig_sign_in" in one)
    assert parse_qs(urlsplit(answer.headers["Location"]).query)["redirect_uri"] == [CALLBACK.replace("http", "https")]


def test_who_is_in_no_group_and_who_gives_a_wrong_password_stay_outside(browser: FlaskClient) -> None:
    refused = sign_in(browser, "zoe")
    assert refused.status_code == 401
    assert "Zoe is in none of the groups" in refused.get_data(as_text=True)
    problem(browser.get("/api/meta"), 401)
    assert at_provider(begin(browser), "anna", "a wrong password") == ""


def test_a_token_lets_no_browser_in_but_scripts(browser: FlaskClient) -> None:
    assert browser.get(f"/?token={TOKEN}").headers["Location"] == "/"  # the address without it
    assert browser.post("/sign-in", data={"token": TOKEN}).headers["Location"] == "/"
    assert browser.get("/").headers["Location"] == "/sign-in"
    problem(browser.get("/api/meta"), 401)
    person = browser.get("/api/meta", headers={"Authorization": f"Bearer {TOKEN}"}).json["person"]
    assert (person["role"], person["all_groups"]) == ("administer", ["north", "south", "readers", "clinic-ward"])


def test_the_way_back_is_good_for_the_browser_that_left_and_once(
    browser: FlaskClient, client_for, config, people
) -> None:
    """Login CSRF: another browser cannot be given somebody's code; nor can the code, state or nonce be another."""
    place = at_provider(begin(browser), "anna")
    other = client_for(replace(config, host="0.0.0.0", token=TOKEN, people=people))
    begin(other)
    assert come_back(other, place).status_code == 401
    query = parse_qs(urlsplit(place).query)
    stolen = f"{CALLBACK}?code={query['code'][0]}&state={parse_qs(urlsplit(begin(other)).query)['state'][0]}"
    assert come_back(other, stolen).status_code == 401  # its PKCE verifier is another's
    problem(other.get("/api/meta"), 401)
    assert come_back(browser, place).status_code in (303, 401)  # the provider may have ended the code
    assert come_back(browser, place).status_code == 401
    denied = browser.get("/sign-in/callback?error=access_denied&error_description=<b>no</b>")
    assert denied.status_code == 401
    assert b"<b>" not in denied.data


def test_the_way_back_leads_nowhere_else(browser: FlaskClient) -> None:
    for extra in ("&next=https://evil.example", "&redirect_uri=//evil.example"):
        assert sign_in_with(browser, extra).headers["Location"] == "/"
    for place in ("/sign-in/start?next=//evil.example", "/sign-in/start?redirect_uri=https://evil.example/"):
        address = browser.get(place).headers["Location"]
        assert parse_qs(urlsplit(address).query)["redirect_uri"] == [CALLBACK]


def sign_in_with(browser: FlaskClient, extra: str):
    return come_back(browser, at_provider(begin(browser), "anna") + extra)


def test_each_sign_in_is_a_new_session_and_ends_the_one_before(browser: FlaskClient) -> None:
    sign_in(browser, "anna")
    first = browser.get_cookie(COOKIE).value
    sign_in(browser, "bea")
    second = browser.get_cookie(COOKIE).value
    assert browser.get("/api/meta").json["person"]["name"] == "Bea"
    browser.set_cookie(COOKIE, first)
    problem(browser.get("/api/meta"), 401)
    browser.set_cookie(COOKIE, second)
    assert browser.post("/sign-out").headers["Clear-Site-Data"] == '"cache", "storage"'
    browser.set_cookie(COOKIE, second)
    problem(browser.get("/api/meta"), 401)


def test_a_session_ends_when_nobody_is_at_the_page_and_at_the_end_of_the_day(browser, monkeypatch) -> None:
    sign_in(browser, "rose")
    start = wall_clock.now()

    def later(minutes: float) -> None:
        monkeypatch.setattr(session.wall_clock, "now", lambda: start + timedelta(minutes=minutes))
        monkeypatch.setattr("itsdangerous.timed.time.time", lambda: (start + timedelta(minutes=minutes)).timestamp())

    later(14)
    assert browser.get("/api/meta").json["person"]["groups"] == ["readers", "clinic-ward"]
    later(16)
    problem(browser.get("/api/meta"), 401)  # to ask is not to be there
    problem(browser.put("/api/session"), 401)
    later(14)
    for minutes in range(14, 720, 14):
        later(minutes)
        assert browser.put("/api/session").status_code == 204
        assert browser.get("/api/meta").status_code == 200
    later(721)
    problem(browser.get("/api/meta"), 401)


def test_a_cookie_of_another_start_or_of_a_token_is_good_for_nothing(browser, client_for, config, people) -> None:
    sign_in(browser, "anna")
    cookie = browser.get_cookie(COOKIE).value
    other = client_for(
        replace(config, host="0.0.0.0", token=TOKEN, people=people.model_copy(update={"key": b"k" * 32}))
    )
    other.set_cookie(COOKIE, cookie)
    problem(other.get("/api/meta"), 401)
    by_token = client_for(replace(config, host="0.0.0.0", token=TOKEN))
    by_token.post("/sign-in", data={"token": TOKEN})
    browser.set_cookie(COOKIE, by_token.get_cookie(COOKIE).value)
    problem(browser.get("/api/meta"), 401)
    by_token.set_cookie(COOKIE, cookie)
    problem(by_token.get("/api/meta"), 401)


def test_a_provider_of_another_name_and_none_are_not_believed(client_for, config: Config, people: People) -> None:
    for issuer in (f"{people.issuer}/", "http://127.0.0.1:9"):
        browser = client_for(replace(config, people=people.model_copy(update={"issuer": issuer})))
        answer = browser.get("/sign-in/start")
        assert (answer.status_code, "did not succeed" in answer.get_data(as_text=True)) == (502, True)


def test_a_claim_that_holds_no_groups_is_a_sentence(client_for, config: Config, people: People) -> None:
    browser = client_for(replace(config, people=people.model_copy(update={"groups_claim": "exp"})))  # a number
    answer = sign_in(browser, "anna")
    assert (answer.status_code, "did not succeed" in answer.get_data(as_text=True)) == (401, True)
