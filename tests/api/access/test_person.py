"""Who calls."""

from apiflask import APIFlask

from breastrig.api.access.person import HOLDER, VISITOR, Role, current_person


def test_without_users_everybody_is_the_holder_of_the_token_but_visitors_of_links(app: APIFlask) -> None:
    assert current_person() == HOLDER
    with app.test_request_context("/api/patients"):
        assert current_person() == HOLDER
    with app.test_request_context("/api/shared/some-link"):
        assert current_person() == VISITOR


def test_a_role_includes_those_before_it() -> None:
    assert [[one.includes(other) for other in Role] for one in Role] == [
        [True, False, False],
        [True, True, False],
        [True, True, True],
    ]
