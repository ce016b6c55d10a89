"""Turns between clients."""

from breastrig.core.round_robin import RoundRobin


def test_each_client_in_turn_gives_its_oldest() -> None:
    row: RoundRobin[str] = RoundRobin()
    for client, item in (("a", "a1"), ("a", "a2"), ("a", "a3"), ("b", "b1"), ("c", "c1"), ("b", "b2")):
        row.put(client, item)
    assert len(row) == 6
    taken = [row.take() for _ in range(7)]
    assert taken == [("a", "a1"), ("b", "b1"), ("c", "c1"), ("a", "a2"), ("b", "b2"), ("a", "a3"), None]
    assert len(row) == 0


def test_who_may_not_is_passed_over_and_keeps_the_place() -> None:
    row: RoundRobin[int] = RoundRobin()
    for client, item in (("a", 1), ("b", 2)):
        row.put(client, item)
    assert row.take(lambda client: client != "a") == ("b", 2)
    assert row.take(lambda client: client != "a") is None
    assert row.take() == ("a", 1)


def test_whoever_leaves_is_not_taken() -> None:
    row: RoundRobin[int] = RoundRobin()
    row.put("a", 1)
    row.put("a", 2)
    assert row.discard("a", 1)
    assert not row.discard("a", 1)
    assert not row.discard("b", 1)
    assert (row.waiting("a"), row.waiting("b")) == (1, 0)
    assert row.take() == ("a", 2)
