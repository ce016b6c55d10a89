"""Who may sign in, as the file of `breastrig serve --users FILE` says: where they are known from, and their groups."""

import secrets
from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field, SecretStr, model_validator

from breastrig.core.errors import BadSettings
from breastrig.core.settings_file import SettingsPart, checked, read_toml

HERE = ("localhost", "127.0.0.1", "::1")  # where a provider may be asked without TLS
NAME_CHARACTERS = 200
Plain = r"^[^\x00-\x1f\x7f,]+$"  # a comma stands between the groups of a proxy's header
HEADER = r"^[A-Za-z0-9-]{1,60}$"


class Role(StrEnum):
    """What a person may do; each role may do all that those before it may."""

    LOOK = "look"
    PLAN = "plan"
    ADMINISTER = "administer"

    def includes(self, other: "Role") -> bool:
        order = list(Role)
        return order.index(self) >= order.index(other)


@dataclass(frozen=True)
class Person:
    """A caller; administrators see all patients, others those that a group of theirs owns."""

    id: str  # the same at each sign-in; says nothing about patients
    name: str  # for people
    role: Role
    groups: tuple[str, ...] = ()


def _checked_issuer(issuer: str) -> str:
    parts = urlsplit(issuer)
    if parts.scheme != "https" and not (parts.scheme == "http" and parts.hostname in HERE):
        raise ValueError("an issuer begins with https://")
    return issuer


class Group(SettingsPart):
    """A group of people."""

    role: Role | None = Field(None, description="that its members have; without one it only owns patients")
    claim: str | None = Field(None, pattern=Plain, max_length=NAME_CHARACTERS, description="the provider's name of it")
    members: tuple[str, ...] = Field((), description="names in the proxy's header, where it sends no groups")


GroupName = Annotated[str, Field(pattern=Plain, max_length=60)]


class People(SettingsPart):
    """The file, checked."""

    issuer: Annotated[str, AfterValidator(_checked_issuer)] | None = None
    client_id: str = ""
    client_secret: SecretStr | None = None
    client_secret_file: Path | None = None
    scopes: tuple[str, ...] = ("openid", "profile")
    groups_claim: str = Field("groups", min_length=1, description="of the ID token or userinfo; dots lead into objects")
    prompt: Literal["login", "select_account", "none"] = Field(
        "login", description="login: the provider asks for the password at each sign-in, none: as it likes"
    )
    proxy_header: str | None = Field(None, pattern=HEADER, description="in which the trusted proxy sends the name")
    proxy_groups_header: str | None = Field(None, pattern=HEADER, description="and the groups, commas between them")
    idle_minutes: int = Field(15, ge=1, le=720)
    groups: dict[GroupName, Group] = Field(min_length=1)
    key: bytes = Field(default_factory=lambda: secrets.token_bytes(32), exclude=True, repr=False)  # of the sessions

    @model_validator(mode="after")
    def _fits_together(self) -> "People":
        if (self.issuer is None) == (self.proxy_header is None):
            raise ValueError("name either an issuer or a proxy_header")
        if self.issuer is not None and not self.client_id:
            raise ValueError("an issuer needs the client_id under which it knows this service")
        if self.client_secret is not None and self.client_secret_file is not None:
            raise ValueError("give client_secret or client_secret_file, not both")
        if "openid" not in self.scopes:
            raise ValueError('scopes need "openid"')
        if self.proxy_groups_header is not None and self.proxy_header is None:
            raise ValueError("proxy_groups_header needs a proxy_header")
        if any(group.members for group in self.groups.values()) and self.proxy_header is None:
            raise ValueError("members are names in a proxy_header; an issuer sends groups")
        if not any(group.role for group in self.groups.values()):
            raise ValueError("give at least one group a role: look, plan or administer")
        if any(not name.strip() for name in self.groups):
            raise ValueError("a group needs a name")
        return self

    def person(self, person_id: str, name: str, named: Collection[str]) -> Person | None:
        """The person, with the groups that the provider or proxy names; None where none of them gives a role."""
        own = tuple(
            group for group, one in self.groups.items() if (one.claim or group) in named or person_id in one.members
        )
        roles = [role for group in own if (role := self.groups[group].role) is not None]
        if not person_id or not roles:
            return None
        greatest = max(roles, key=list(Role).index)
        return Person(person_id[:NAME_CHARACTERS], name[:NAME_CHARACTERS] or person_id, greatest, own)

    def secret(self) -> str | None:
        """The client's secret; None for a client without one.  Raises BadSettings when its file cannot be read."""
        if self.client_secret_file is None:
            return None if self.client_secret is None else self.client_secret.get_secret_value()
        try:
            return self.client_secret_file.read_text(encoding="utf-8").strip()
        except (OSError, UnicodeDecodeError) as error:
            raise BadSettings(
                f"The file {self.client_secret_file} of the client's secret cannot be read; check its permissions."
            ) from error


def read_people(file: Path) -> People:
    """The people of a file.  Raises BadSettings with what is wrong in it."""
    people = checked(People, read_toml(file, "users", "see docs/how-to/people.md"), str(file))
    if people.client_secret_file is not None and not people.client_secret_file.is_absolute():
        people = people.model_copy(update={"client_secret_file": file.parent / people.client_secret_file})
    people.secret()
    return people
