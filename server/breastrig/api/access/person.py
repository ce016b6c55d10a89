"""Who calls: a person who has signed in, the holder of the service's token, or a visitor of a share link."""

from flask import g, has_request_context, request

from breastrig.api.people.people import Person as Person
from breastrig.api.people.people import Role as Role

HOLDER = Person("token", "Holder of the token", Role.ADMINISTER)  # a script, or anybody where there are no users
VISITOR = Person("visitor", "Visitor of a link", Role.LOOK)
NOBODY = Person("", "Nobody", Role.LOOK)  # has not signed in


def current_person() -> Person:
    """Who asks for the request at hand; outside of a request, and without `--users`, the holder of the token."""
    if not has_request_context():
        return HOLDER
    if is_visitor():
        return VISITOR
    person: Person = g.get("person", HOLDER)
    return person


def is_visitor() -> bool:
    """Whether the call is for visitors of share links, who bring a credential that the call checks."""
    return has_request_context() and (request.endpoint or "").startswith("shared.")


def note_person(person: Person) -> None:
    """It is this person who asks for the request at hand."""
    g.person = person


def groups_in_reach() -> tuple[str, ...] | None:
    """The groups whose patients whoever asks may know of; None for all patients.

    Visitors reach what their link shows, which their credential decides.
    """
    person = current_person()
    return None if person.role is Role.ADMINISTER or is_visitor() else person.groups
