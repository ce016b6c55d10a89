"""The JSON shapes of who asks, and of groups of people."""

from pydantic import Field

from breastrig.api.people.people import Role
from breastrig.api.wire.common import GROUP, Wire


class Caller(Wire):
    """Who asks."""

    id: str = Field(description="the same at each sign-in")
    name: str
    role: Role = Field(description="each may do what those before it may")
    groups: list[str] = Field(description="one of which is to own a new patient")
    all_groups: list[str] = Field(description="to which a patient can be given; empty for who is no administrator")
    idle_minutes: int | None = Field(description="after which the session ends unless it is kept; null: by the proxy")


class GroupQuery(Wire):
    group: str | None = Field(None, max_length=60, description=GROUP)


class GivenGroup(Wire):
    group: str | None = Field(max_length=60, description="null: none, so that administrators alone see the patient")
