"""The file of users, and people whom a proxy names."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from flask.testing import FlaskClient
from helpers.persons import PROXY, TOKEN, person_client, with_people
from helpers.problems import problem

from breastrig.api.config import Config, checked_token
from breastrig.api.people.people import People, Role, read_people
from breastrig.core.errors import BadSettings

GROUPS = '[groups.north]\nrole = "plan"\n'
ISSUER = 'issuer = "https://login.example/realms/clinic"\nclient_id = "breastrig"\n'


def read(folder: Path, text: str) -> People:
    file = folder / "users.toml"
    file.write_text(text)
    return read_people(file)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "groups"),
        (GROUPS, "either an issuer or a proxy_header"),
        (ISSUER, "groups"),
        (f'{ISSUER}proxy_header = "X-Remote-User"\n{GROUPS}', "either an issuer or a proxy_header"),
        (f'issuer = "https://login.example"\n{GROUPS}', "client_id"),
        (f'issuer = "http://login.example"\nclient_id = "b"\n{GROUPS}', "https://"),
        (f'issuer = "http://127.0.0.1.evil.example"\nclient_id = "b"\n{GROUPS}', "https://"),
        (f'{ISSUER}scopes = ["profile"]\n{GROUPS}', "openid"),
        (f'{ISSUER}password = "x"\n{GROUPS}', "password"),
        (f"{ISSUER}idle_minutes = 0\n{GROUPS}", "idle_minutes"),
        (f'{ISSUER}client_secret_file = "nowhere"\n{GROUPS}', "cannot be read"),
        (f'{ISSUER}client_secret = "a"\nclient_secret_file = "b"\n{GROUPS}', "not both"),
        (f'{ISSUER}[groups.north]\nrole = "chief"\n', "groups.north.role"),
        (f"{ISSUER}[groups.north]\n", "a role"),
        (f'{ISSUER}[groups.north]\nrole = "plan"\nmembers = ["anna"]\n', "members"),
        (f'{ISSUER}proxy_groups_header = "X-Groups"\n{GROUPS}', "proxy_groups_header"),
        (f'proxy_header = "X Remote"\n{GROUPS}', "proxy_header"),
        (f'{ISSUER}[groups."a,b"]\nrole = "plan"\n', "groups"),
        (f'{ISSUER}[groups." "]\nrole = "plan"\n', "name"),
        ("issuer = ", "TOML"),
    ],
)
def test_a_file_that_cannot_be_meant_is_refused_in_a_sentence(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(BadSettings, match=said):
        read(tmp_path, text)


def test_the_secret_is_beside_the_file_and_in_no_text(tmp_path: Path) -> None:
    (tmp_path / "client_secret").write_text("hidden words\n")
    people = read(tmp_path, f'{ISSUER}client_secret_file = "client_secret"\n{GROUPS}')
    assert people.secret() == "hidden words"
    inline = read(tmp_path, f'{ISSUER}client_secret = "hidden words"\n{GROUPS}')
    assert inline.secret() == "hidden words"
    for each in (people, inline):
        assert "hidden" not in repr(each)
        assert repr(each.key) not in repr(each)
    assert people.key != inline.key


def test_a_person_has_the_greatest_role_of_the_groups_and_only_those_of_the_file(tmp_path: Path) -> None:
    people = read(
        tmp_path,
        f'{ISSUER}[groups.north]\nrole = "plan"\n[groups.board]\nclaim = "0-1"\nrole = "administer"\n[groups.ward]\n',
    )
    person = people.person("7", "Anna", ["north", "0-1", "ward", "elsewhere"])
    assert person is not None
    assert (person.role, person.groups) == (Role.ADMINISTER, ("north", "board", "ward"))
    assert people.person("7", "Anna", ["ward", "board"]) is None  # the provider's name of the board is another
    assert people.person("", "Anna", ["north"]) is None


def test_users_take_no_token_of_their_own_making_and_not_none_for_all() -> None:
    assert checked_token("0.0.0.0", None, users=True) is None
    assert checked_token("0.0.0.0", TOKEN, users=True) == TOKEN
    with pytest.raises(BadSettings, match="--no-token"):
        checked_token("127.0.0.1", None, no_token=True, users=True)


@pytest.fixture
def anna(client_for: Callable[[Config], FlaskClient], config: Config) -> FlaskClient:
    return person_client(client_for, config, "anna", "north")


def test_the_proxys_name_is_believed_from_its_address_alone(anna: FlaskClient, client_for, config: Config) -> None:
    assert anna.get("/api/meta").json["person"] == {
        "id": "anna", "name": "anna", "role": "plan", "groups": ["north"], "all_groups": [], "idle_minutes": None,
    }  # fmt: skip
    assert anna.get("/").status_code == 200
    for address in ("10.0.0.7", "127.0.0.2", "::1", ""):
        problem(anna.get("/api/meta", environ_overrides={"REMOTE_ADDR": address}), 401)
    elsewhere = client_for(replace(with_people(config), trusted_proxy=None))
    elsewhere.environ_base |= anna.environ_base
    problem(elsewhere.get("/api/meta", headers={"Host": "localhost"}), 401)
    assert anna.get("/", environ_overrides={"REMOTE_ADDR": "10.0.0.7"}).headers["Location"] == "/sign-in"


@pytest.mark.parametrize("name", ["", " ", "root,anna", "anna,root", "x" * 300, "a\x7fb"])
def test_a_name_that_is_none_or_two_is_nobody(anna: FlaskClient, name: str) -> None:
    problem(anna.get("/api/meta", environ_overrides={"HTTP_X_REMOTE_USER": name}), 401)


@pytest.mark.parametrize("header", ["x-remote-user", "X-Remote-Groups"])
def test_a_header_that_came_twice_is_not_believed(anna: FlaskClient, header: str) -> None:
    """One of them may be the client's own, which a careless proxy let pass."""
    given = ((b"x-remote-user", b"anna"), (b"x-remote-groups", b"north"), (header.encode(), b"board"))
    answer = anna.get("/api/meta", environ_overrides={"asgi.scope": {"headers": given}})
    problem(answer, 401)
    assert anna.get("/api/meta", environ_overrides={"asgi.scope": {"headers": given[:2]}}).status_code == 200


def test_members_of_the_file_need_no_groups_of_the_proxy(anna: FlaskClient) -> None:
    root = {"HTTP_X_REMOTE_USER": "root", "HTTP_X_REMOTE_GROUPS": ""}
    assert anna.get("/api/meta", environ_overrides=root).json["person"]["role"] == "administer"
    problem(anna.get("/api/meta", environ_overrides=root | {"HTTP_X_REMOTE_USER": "nobody"}), 401)


def test_a_request_of_another_site_changes_nothing_though_the_proxy_names_a_person(anna: FlaskClient) -> None:
    problem(anna.post("/api/examples/standing", headers={"Origin": "https://evil.example"}), 403)
    problem(anna.post("/api/examples/standing", headers={"Sec-Fetch-Site": "cross-site"}), 403)
    assert PROXY == "127.0.0.1"
