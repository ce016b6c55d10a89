"""Groups of people: which one owns a new patient, and what is said of them to who asks."""

from breastrig.api.access.person import Role, current_person
from breastrig.api.app_context import config
from breastrig.api.wire import persons as wire
from breastrig.core.errors import BadSettings, unknown_name


def group_for_new(asked: str | None) -> str | None:
    """The group that owns a patient whom the caller makes; None where there are no users.

    Raises 403 for who is in no group, BadSettings where one of several has to be named, and for one that is not theirs.
    """
    people, person = config.people, current_person()
    if people is None:
        return None
    is_administrator = person.role is Role.ADMINISTER
    may = tuple(people.groups) if is_administrator else person.groups
    if asked is not None:
        if asked not in may:
            raise BadSettings(unknown_name("group of yours", asked, may))
        return asked
    if len(person.groups) > 1:
        raise BadSettings(f"You are in several groups; name the one that owns the patient: {', '.join(person.groups)}.")
    return person.groups[0] if person.groups else None


def caller_answer() -> wire.Caller | None:
    """Who asks, as the page shows it; None where there are no users."""
    people, person = config.people, current_person()
    if people is None:
        return None
    is_administrator = person.role is Role.ADMINISTER
    return wire.Caller.of(
        person,
        all_groups=list(people.groups) if is_administrator else [],
        idle_minutes=people.idle_minutes if people.proxy_header is None else None,
    )
