"""What is believed of a reverse proxy: which headers, how many of them, from whom."""

from dataclasses import replace
from typing import Any

import pytest
from flask.testing import FlaskClient
from helpers.problems import problem

from breastrig.api.config import Config, checked_token
from breastrig.api.settings import effective_settings
from breastrig.api.trusted_proxy import FORWARDED, BehindProxy, client_of, read_trusted_proxy
from breastrig.core.errors import BadSettings

TOKEN = "a-token-of-more-than-sixteen-characters"


def seen(proxy: str | None, address: str, **headers: str) -> dict[str, Any]:
    """The environ that the application sees."""
    environ = {"REMOTE_ADDR": address, "HTTP_HOST": "inside:8321", "wsgi.url_scheme": "http"}
    environ |= {f"HTTP_{name.upper()}": value for name, value in headers.items()}
    behind = BehindProxy(lambda _environ, _start: [], None if proxy is None else read_trusted_proxy(proxy))
    behind(environ, None)
    once = dict(environ)
    behind(environ, None)
    assert environ == once
    return environ


FORGED = {"x_forwarded_for": "8.8.8.8", "x_forwarded_proto": "https", "x_forwarded_host": "evil.example"}


@pytest.mark.parametrize(
    ("proxy", "address"), [(None, "10.0.0.1"), ("10.0.0.1", "10.0.0.2"), ("10.0.0.1", ""), ("10.0.0.0/31", "10.0.0.2")]
)
def test_from_anybody_else_nothing_is_believed_and_nothing_is_left_to_be_read(proxy: str | None, address: str) -> None:
    environ = seen(proxy, address, **FORGED, x_real_ip="8.8.8.8", forwarded="for=8.8.8.8")
    assert environ == {"REMOTE_ADDR": address, "HTTP_HOST": "inside:8321", "wsgi.url_scheme": "http"}


@pytest.mark.parametrize(
    ("proxy", "address"),
    [
        ("10.0.0.1", "10.0.0.1"),
        ("10.0.0.0/24", "10.0.0.77"),
        ("10.0.0.1", "::ffff:10.0.0.1"),
        ("fd00::1", "fd00::1"),
        (" 10.0.0.1 , 1 ", "10.0.0.1"),
    ],
)
def test_from_the_proxy_the_last_of_each_is_believed(proxy: str, address: str) -> None:
    headers = {name: f"made up, {value}" for name, value in FORGED.items()}
    environ = seen(proxy, address, **headers)
    assert (environ["REMOTE_ADDR"], environ["wsgi.url_scheme"]) == ("8.8.8.8", "https")
    assert (environ["HTTP_HOST"], environ[FORWARDED]) == ("evil.example", True)


def test_with_two_proxies_in_a_row_the_last_but_one_is_believed() -> None:
    headers = {"x_forwarded_for": "1.1.1.1, 8.8.8.8, 10.0.0.9", "x_forwarded_proto": "ftp, https, http"}
    environ = seen("10.0.0.1,2", "10.0.0.1", **headers)
    assert (environ["REMOTE_ADDR"], environ["wsgi.url_scheme"]) == ("8.8.8.8", "https")
    alone = seen("10.0.0.1,2", "10.0.0.1", x_forwarded_for="8.8.8.8")  # it has passed one proxy only
    assert alone["REMOTE_ADDR"] == "10.0.0.1"


def test_a_proxy_that_says_nothing_is_known_as_the_proxy() -> None:
    assert seen("10.0.0.1", "10.0.0.1")[FORWARDED] is False
    assert FORWARDED not in seen("10.0.0.1", "10.0.0.2")


def test_clients_are_counted_by_address_and_by_network_where_a_house_has_a_whole_one() -> None:
    assert client_of("10.0.0.1") == client_of("::ffff:10.0.0.1") == "10.0.0.1"
    assert client_of("2001:db8:1:2::1") == client_of("2001:db8:1:2:ffff::9") != client_of("2001:db8:1:3::1")
    assert client_of("::1") == "::1"
    assert client_of(None) == client_of("") == client_of("_hidden") == "unknown"


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("trusted_proxy", "nginx", "is not the address of a proxy"),
        ("trusted_proxy", "10.0.0.1/24", "is not the address of a proxy"),
        ("trusted_proxy", "0.0.0.0/0", "would believe everybody"),
        ("trusted_proxy", "10.0.0.1,0", "no number of proxies"),
        ("trusted_proxy", "10.0.0.1,two", "no number of proxies"),
        ("public_host", "https://scans.example", "is no name of a host"),
        ("public_host", "scans.example:443", "is no name of a host"),
        ("public_host", "a,,b", "is no name of a host"),
    ],
)
def test_a_wrong_value_is_named(name: str, text: str, sentence: str) -> None:
    with pytest.raises(BadSettings, match=sentence):
        effective_settings({name: text}, None, {})


def test_right_values_are_shown_as_they_were_given() -> None:
    given = {
        "trusted_proxy": "10.0.0.1,2",
        "public_host": "Scans.Example, ::1",
    }
    found = effective_settings(given, None, {"BREASTRIG_TRUSTED_PROXY": "10.9.9.9"})
    assert [found[name].shown for name in given] == ["10.0.0.1,2", "scans.example,::1"]
    assert effective_settings({}, None, {"BREASTRIG_TRUSTED_PROXY": "10.9.9.9"})["trusted_proxy"].shown == "10.9.9.9"


def test_behind_a_proxy_a_token_is_needed_on_any_address() -> None:
    proxy = read_trusted_proxy("127.0.0.1")
    with pytest.raises(BadSettings, match="through a proxy would show patients' scans"):
        checked_token("127.0.0.1", None, proxy)
    assert checked_token("127.0.0.1", TOKEN, proxy) == TOKEN


@pytest.mark.parametrize(
    ("changes", "host", "status"),
    [
        ({}, "scans.example", 200),  # the token protects
        ({"public_hosts": ("scans.example",)}, "scans.example:444", 200),
        ({"public_hosts": ("scans.example",)}, "localhost:8321", 200),
        ({"public_hosts": ("scans.example",)}, "evil.example", 421),
        ({"public_hosts": ("scans.example",), "host": "0.0.0.0"}, "evil.example", 421),
    ],
)
def test_the_public_name_is_the_only_one_where_it_is_given(
    client_for, config: Config, changes: dict[str, Any], host: str, status: int
) -> None:
    used = replace(config, token=TOKEN, trusted_proxy=read_trusted_proxy("127.0.0.1"), **changes)
    assert client_for(used).get("/healthz", headers={"Host": host}).status_code == status


@pytest.mark.parametrize(
    ("origin", "host"),
    [("https://scans.example", "scans.example:443"), ("https://scans.example:443", "scans.example")],
)
def test_the_port_of_the_scheme_makes_no_foreign_page(client_for, config: Config, origin: str, host: str) -> None:
    client: FlaskClient = client_for(replace(config, token=TOKEN, trusted_proxy=read_trusted_proxy("127.0.0.1")))
    headers = {"Authorization": f"Bearer {TOKEN}", "Origin": origin, "X-Forwarded-For": "10.1.1.1"}
    forwarded = {"X-Forwarded-Proto": "https", "X-Forwarded-Host": host}
    assert client.delete("/api/scans/nobody", headers=headers | forwarded).status_code == 204
    other_port = forwarded | {"X-Forwarded-Host": "scans.example:8443"}
    problem(client.delete("/api/scans/nobody", headers=headers | other_port), 403)
