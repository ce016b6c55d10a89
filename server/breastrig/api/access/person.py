"""Who calls: a person who has signed in, the holder of the service's token, or a visitor of a share link."""

from dataclasses import dataclass
from enum import StrEnum

from flask import g, has_request_context, request


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


HOLDER = Person("token", "Holder of the token", Role.ADMINISTER)  # a script, or anybody where there are no users
VISITOR = Person("visitor", "Visitor of a link", Role.LOOK)


def current_person() -> Person:
    """Who asks for the request at hand; outside of a request, and without `--users`, the holder of the token."""
    if not has_request_context():
        return HOLDER
    if (request.endpoint or "").startswith("shared."):
        return VISITOR
    person: Person = g.get("person", HOLDER)
    return person
