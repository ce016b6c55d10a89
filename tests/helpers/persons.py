"""Clients of persons whom a trusted proxy names."""

from collections.abc import Callable
from dataclasses import replace

from flask.testing import FlaskClient

from breastrig.api.config import Config
from breastrig.api.people.people import People
from breastrig.api.trusted_proxy import read_trusted_proxy

TOKEN = "a-token-of-more-than-sixteen-characters"
PROXY = "127.0.0.1"
PEOPLE = People.model_validate(
    {
        "proxy_header": "X-Remote-User",
        "proxy_groups_header": "X-Remote-Groups",
        "groups": {
            "north": {"role": "plan"},
            "south": {"role": "plan"},
            "readers": {"role": "look"},
            "board": {"role": "administer", "members": ["root"]},
            "ward": {},
        },
    }
)


def with_people(config: Config, people: People = PEOPLE) -> Config:
    return replace(config, people=people, token=TOKEN, trusted_proxy=read_trusted_proxy(PROXY))


def person_client(client_for: Callable[[Config], FlaskClient], config: Config, name: str, *groups: str) -> FlaskClient:
    """The browser of a person who comes through the proxy."""
    client = client_for(with_people(config))
    client.environ_base |= {
        "REMOTE_ADDR": PROXY,
        "HTTP_X_FORWARDED_FOR": "10.0.0.7",
        "HTTP_X_FORWARDED_HOST": "localhost",
        "HTTP_X_REMOTE_USER": name,
        "HTTP_X_REMOTE_GROUPS": ",".join(groups),
    }
    return client
