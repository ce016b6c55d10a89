"""Browsers and the token: the sign-in page, its cookie, and what the cookie is good for."""

import io
import re
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import itsdangerous.timed
import pytest
from flask.testing import FlaskClient
from helpers.on_disk import bytes_below
from helpers.problems import problem
from limits import RateLimitItemPerMinute

from breastrig.api.access import rate_limits, session
from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.service.service import Service
from breastrig.storage.storage import Storage

TOKEN = "a-token-of-more-than-sixteen-characters"


@pytest.fixture
def browser(client_for, config: Config) -> FlaskClient:
    """Keeps cookies like a browser; nobody has signed in."""
    return client_for(replace(config, host="0.0.0.0", token=TOKEN))


def sign_in(browser: FlaskClient, token: str = TOKEN, **kwargs: object):
    return browser.post("/sign-in", data={"token": token}, **kwargs)


def test_a_browser_is_led_to_the_sign_in_page_and_from_there_to_the_page(browser: FlaskClient) -> None:
    first = browser.get("/")
    assert (first.status_code, first.headers["Location"]) == (303, "/sign-in")
    form = browser.get("/sign-in")
    assert (form.status_code, form.mimetype, form.headers["Cache-Control"]) == (200, "text/html", "no-store")
    assert form.headers["Referrer-Policy"] == "same-origin"  # else browsers send the form with "Origin: null"
    html = form.get_data(as_text=True)
    assert 'type="password"' in html
    assert "<script" not in html
    assert 'style="' not in html
    assert "//" not in html
    [style] = re.findall(r'href="([^"]+\.css)"', html)
    assert browser.get(style).mimetype == "text/css"
    answer = sign_in(browser, f" {TOKEN} ")
    assert (answer.status_code, answer.headers["Location"]) == (303, "/")
    assert b"the page" in browser.get("/").data
    assert browser.get("/api/meta").status_code == 200
    assert "You are signed in" in browser.get("/sign-in").get_data(as_text=True)


def test_the_address_with_the_token_lets_a_browser_in_and_leads_to_the_one_without_it(browser: FlaskClient) -> None:
    wrong = browser.get("/?token=wrong")
    assert (wrong.status_code, "Set-Cookie" in wrong.headers) == (401, False)
    assert "This is not the token." in wrong.get_data(as_text=True)
    problem(browser.get("/api/meta"), 401)
    answer = browser.get(f"/?token={TOKEN}")
    assert (answer.status_code, answer.headers["Location"], answer.headers["Cache-Control"]) == (303, "/", "no-store")
    assert answer.headers["Referrer-Policy"] == "no-referrer"
    assert TOKEN not in answer.headers["Set-Cookie"]
    assert b"the page" in browser.get("/").data
    assert browser.get("/api/meta").status_code == 200
    for given in (TOKEN, "of the start before"):  # a bookmark of a signed-in browser
        again = browser.get(f"/?token={given}")
        assert (again.status_code, again.headers["Location"]) == (303, "/")


def test_wrong_tokens_in_the_address_are_limited_as_others_are(browser: FlaskClient) -> None:
    most = rate_limits.PER_MINUTE["sign-in"].amount
    assert [browser.get("/?token=wrong").status_code for _ in range(most + 1)] == [401] * most + [429]
    assert browser.get(f"/?token={TOKEN}").status_code == 303


def test_a_page_of_another_site_that_leads_here_is_asked_again_by_our_own(browser: FlaskClient) -> None:
    """The browser keeps a SameSite=Strict cookie back on the whole way that began elsewhere, redirects included."""
    foreign = browser.get("/", headers={"Sec-Fetch-Site": "cross-site"})
    assert (foreign.status_code, foreign.headers["Refresh"], foreign.data) == (200, "0; url=/", b"")
    assert browser.get("/", headers={"Sec-Fetch-Site": "same-origin"}).status_code == 303
    sign_in(browser)
    assert b"the page" in browser.get("/", headers={"Sec-Fetch-Site": "cross-site"}).data


def test_services_on_two_ports_of_a_machine_keep_their_sessions_apart(client_for, config: Config) -> None:
    ports = {"http://localhost:8321": "breastrig_session_8321", "http://localhost:8322": "breastrig_session_8322"}
    tokens = (TOKEN, TOKEN[::-1])
    first, second = (client_for(replace(config, token=token)) for token in tokens)
    kept: dict[str, str] = {}  # a browser's, which sends all of a host's to each port
    for (address, name), one, token in zip(ports.items(), (first, second), tokens, strict=True):
        cookie = one.get(f"/?token={token}", base_url=address).headers["Set-Cookie"].partition(";")[0]
        assert cookie.startswith(f"{name}=")
        kept[name] = cookie.partition("=")[2]
    for address, one in zip(ports, (first, second), strict=True):
        for name, value in kept.items():
            one.set_cookie(name, value)
        assert one.get("/api/meta", base_url=address).status_code == 200


def test_the_cookie_is_out_of_reach_of_scripts_and_other_sites_and_does_not_hold_the_token(
    browser: FlaskClient,
) -> None:
    cookie = sign_in(browser).headers["Set-Cookie"]
    assert cookie.startswith(f"{session.COOKIE}=")
    for word in ("HttpOnly", "SameSite=Strict", "Path=/", f"Max-Age={session.LASTS_S}"):
        assert word in cookie
    assert "Secure" not in cookie
    assert TOKEN not in cookie
    assert "Secure" in sign_in(browser, base_url="https://scans.example").headers["Set-Cookie"]


@pytest.mark.parametrize("token", ["", "wrong", TOKEN[:-1], TOKEN + "x", "é", "\ud800", "x" * 9000])
def test_a_wrong_token_gets_no_cookie(browser: FlaskClient, token: str) -> None:
    data = {"token": token.encode("utf-8", "surrogatepass")}
    answer = browser.post("/sign-in", data=data)
    assert answer.status_code == 401
    assert "This is not the token." in answer.get_data(as_text=True)
    assert answer.headers["Referrer-Policy"] == "same-origin"
    assert "Set-Cookie" not in answer.headers
    problem(browser.get("/api/meta"), 401)


def test_a_form_that_is_none_gets_no_cookie(browser: FlaskClient) -> None:
    for body, kind in ((b"{}", "application/json"), (b"", None), (b"token", "text/plain")):
        assert browser.post("/sign-in", data=body, content_type=kind).status_code == 401
    big = browser.post("/sign-in", data={"token": "x" * 20_000})
    problem(big, 413)


def test_a_session_ends_when_it_is_left_when_it_is_old_and_when_the_token_changes(
    browser: FlaskClient, client_for, config: Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    sign_in(browser)
    cookie = browser.get_cookie(session.COOKIE)
    assert cookie is not None
    other = client_for(replace(config, host="0.0.0.0", token=TOKEN[::-1]))
    other.set_cookie(session.COOKIE, cookie.value)
    problem(other.get("/api/meta"), 401)
    with monkeypatch.context() as later:
        later.setattr(session, "LASTS_S", -1)
        problem(browser.get("/api/meta"), 401)
    assert browser.get("/api/meta").status_code == 200
    left = browser.post("/sign-out")
    assert (left.status_code, left.headers["Location"]) == (303, "/sign-in")
    assert left.headers["Clear-Site-Data"] == '"cache", "storage"'  # "cookies" would be other programs' too
    problem(browser.get("/api/meta"), 401)


@pytest.mark.parametrize(("hours", "good"), [(-11.9, True), (-12.1, False), (1.0, True), (11.9, True), (12.1, False)])
def test_a_clock_that_is_set_back_an_hour_signs_nobody_out_and_no_session_outlives_a_day(
    hours: float, good: bool, browser: FlaskClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Signed in so many hours from now, as the clock has it."""
    with monkeypatch.context() as clock:
        clock.setattr(itsdangerous.timed.time, "time", lambda: now + 3600 * hours)
        now = datetime.now(UTC).timestamp()
        sign_in(browser)
    assert browser.get("/api/meta").status_code == (200 if good else 401)


def test_a_session_that_was_left_stays_so_whatever_the_clock_did(
    browser: FlaskClient, client_for, config: Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody else signs out while the clock is weeks ahead, and then it is set right."""
    colleague = client_for(replace(config, host="0.0.0.0", token=TOKEN))
    sign_in(browser)
    cookie = browser.get_cookie(session.COOKIE)
    assert cookie is not None
    browser.post("/sign-out")
    now = datetime.now(UTC) + timedelta(days=40)
    with monkeypatch.context() as clock:
        clock.setattr(itsdangerous.timed.time, "time", now.timestamp)
        clock.setattr(session.wall_clock, "now", lambda: now)
        sign_in(colleague)
        colleague.post("/sign-out")
    browser.set_cookie(session.COOKIE, cookie.value)
    problem(browser.get("/api/meta"), 401)


@pytest.mark.slow
def test_a_copied_cookie_is_worth_nothing_after_signing_out(
    browser: FlaskClient, client_for, config: Config, service: Service
) -> None:
    thief, colleague = (client_for(replace(config, host="0.0.0.0", token=TOKEN)) for _ in range(2))
    sign_in(browser)
    sign_in(colleague)
    cookie = browser.get_cookie(session.COOKIE)
    assert cookie is not None
    thief.set_cookie(session.COOKIE, cookie.value)
    assert thief.get("/api/meta").status_code == 200
    for _ in range(2):
        browser.post("/sign-out")
        browser.set_cookie(session.COOKIE, cookie.value)
    problem(browser.get("/api/meta"), 401)
    problem(thief.get("/api/meta"), 401)
    assert thief.get("/").status_code == 303
    assert colleague.get("/api/meta").status_code == 200
    restarted = create_app(replace(config, host="0.0.0.0", token=TOKEN), Service(Storage(service.storage.root)))
    answer = restarted.test_client().get("/api/meta", headers={"Cookie": f"{session.COOKIE}={cookie.value}"})
    assert answer.status_code == 401
    assert cookie.value.encode() not in bytes_below(service.storage.root)


def test_cookies_of_before_a_lost_index_open_nothing(
    browser: FlaskClient, client_for, config: Config, lose_index, scan_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which of them had been left is not known any more.  A data folder without patients had no index to lose."""
    colleague = client_for(replace(config, host="0.0.0.0", token=TOKEN))
    with monkeypatch.context() as clock:
        clock.setattr(itsdangerous.timed.time, "time", lambda: now - 2.0)
        now = datetime.now(UTC).timestamp()
        sign_in(browser)
        sign_in(colleague)
    cookie = browser.get_cookie(session.COOKIE)
    assert cookie is not None
    browser.post("/sign-out")
    browser.set_cookie(session.COOKIE, cookie.value)
    lose_index()
    for one in (browser, colleague):
        problem(one.get("/api/meta"), 401)
        sign_in(one)
        assert one.get("/api/meta").status_code == 200


def test_signing_out_without_a_session_is_no_error(browser: FlaskClient, client: FlaskClient) -> None:
    for one in (browser, client):
        assert one.post("/sign-out").status_code == 303


@pytest.mark.parametrize("value", ["", "x", "a.b.c", "InNpZ25lZCBpbiI.aaaaaa.bbbbbbbbbbbbbbbbbbbbbbbbbbb"])
def test_a_made_up_cookie_opens_nothing(browser: FlaskClient, value: str) -> None:
    browser.set_cookie(session.COOKIE, value)
    problem(browser.get("/api/meta"), 401)
    assert browser.get("/").status_code == 303


def test_another_site_can_neither_sign_a_browser_in_nor_use_its_session(browser: FlaskClient) -> None:
    foreign = {"Origin": "http://evil.example"}
    problem(sign_in(browser, headers=foreign), 403)
    sign_in(browser)
    problem(browser.delete("/api/scans/nobody", headers=foreign), 403)
    problem(browser.post("/sign-out", headers=foreign), 403)
    assert browser.delete("/api/scans/nobody").status_code == 204


def test_wrong_tokens_are_limited_for_each_address_alone_and_keep_nobody_out_who_has_the_right_one(
    browser: FlaskClient,
) -> None:
    answers = [sign_in(browser, "wrong") for _ in range(rate_limits.PER_MINUTE["sign-in"].amount + 1)]
    assert [answer.status_code for answer in answers[:-1]] == [401] * (len(answers) - 1)
    assert answers[-1].status_code == 429
    assert 1 <= int(answers[-1].headers["Retry-After"]) <= 61
    assert "Too many attempts" in answers[-1].get_data(as_text=True)
    assert sign_in(browser, "wrong again", environ_base={"REMOTE_ADDR": "10.0.0.9"}).status_code == 401
    assert "Set-Cookie" not in answers[-1].headers
    assert sign_in(browser).status_code == 303
    assert browser.get("/api/meta").status_code == 200
    assert sign_in(browser, "wrong again").status_code == 429  # the right one of a colleague begins nothing anew


def test_beyond_a_number_of_tries_from_an_address_no_token_is_looked_at(
    browser: FlaskClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So guesses are bounded also by what they can find, not only by what they are answered."""
    monkeypatch.setitem(rate_limits.PER_MINUTE, "sign-in tried", RateLimitItemPerMinute(4))
    near, far = {"REMOTE_ADDR": "2001:db8:1:2::5"}, {"REMOTE_ADDR": "2001:db8:1:3::5"}
    codes = [sign_in(browser, f"guess {number}", environ_base=near).status_code for number in range(4)]
    assert codes == [401] * 4
    refused = sign_in(browser, environ_base=near | {"REMOTE_ADDR": "2001:db8:1:2::6"})  # the right token, same house
    assert (refused.status_code, "Set-Cookie" in refused.headers) == (429, False)
    assert 1 <= int(refused.headers["Retry-After"]) <= 61
    assert sign_in(browser, environ_base=far).status_code == 303


def test_uploads_are_limited(browser: FlaskClient, monkeypatch: pytest.MonkeyPatch, torso: bytes) -> None:
    monkeypatch.setitem(rate_limits.PER_MINUTE, "upload", RateLimitItemPerMinute(1))
    sign_in(browser)
    data = {"units": "m"}
    answers = [browser.post("/api/scans", data=data, content_type="multipart/form-data") for _ in range(2)]
    problem(answers[0], 422)
    for _ in range(2):
        last = browser.post("/api/scans", data={"file": (io.BytesIO(torso), "x.exe")})
    assert "Too many" in problem(last, 429)
    assert int(last.headers["Retry-After"]) >= 1


def test_without_a_token_nobody_signs_in(client: FlaskClient) -> None:
    assert "needs no token" in client.get("/sign-in").get_data(as_text=True)
    answer = sign_in(client, "anything")
    assert (answer.status_code, answer.headers["Location"]) == (303, "/")
    assert "Set-Cookie" not in answer.headers
    answer = client.get("/?token=anything")
    assert (answer.status_code, answer.headers["Location"]) == (303, "/")
