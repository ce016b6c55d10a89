"""Work that many ask for at once is done once."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from breastrig.core.errors import BadScan, TooMany
from breastrig.service import remembered
from breastrig.service.remembered import Remembered


class Work:
    """Counts how often it is done; goes on when the test says so."""

    def __init__(self, error: Exception | None = None) -> None:
        self.begun, self.go_on, self.times, self._error = threading.Event(), threading.Event(), 0, error

    def __call__(self) -> str:
        self.times += 1
        self.begun.set()
        assert self.go_on.wait(30)
        if self._error is not None:
            raise self._error
        return f"made {self.times}"


def asked_at_once(flights: Remembered[str], work: Work, others: int) -> list:
    """The futures of the first and of those that came while it was at work."""
    pool = ThreadPoolExecutor(others + 1)
    tasks = [pool.submit(flights.result, "key", work)]
    assert work.begun.wait(30)
    tasks += [pool.submit(flights.result, "key", work) for _ in range(others)]
    while flights._kept.get("key").waiting < min(others, remembered.MOST_WAITING):
        threading.Event().wait(0.001)
    pool.shutdown(wait=False)
    return tasks


def test_all_who_come_while_it_is_made_get_the_same() -> None:
    flights, work = Remembered[str](2), Work()
    tasks = asked_at_once(flights, work, 5)
    assert flights.result("another key", lambda: "at once") == "at once"
    work.go_on.set()
    assert [task.result(30) for task in tasks] == ["made 1"] * 6
    assert flights.result("key", work) == "made 1"
    flights.forget()
    assert flights.result("key", work) == "made 2"


def test_the_last_ones_are_kept() -> None:
    flights, asked = Remembered[str](2), "abacab"
    made = [flights.result(key, lambda number=number: f"{number}") for number, key in enumerate(asked)]
    assert made == ["0", "1", "0", "3", "0", "5"]


def test_what_is_forgotten_while_it_is_made_is_not_kept() -> None:
    flights, work = Remembered[str](2), Work()
    tasks = asked_at_once(flights, work, 1)
    flights.forget()
    work.go_on.set()
    assert {task.result(30) for task in tasks} == {"made 1"}
    assert flights.result("key", work) == "made 2"


def test_an_error_is_everybodys_and_the_next_one_tries_again() -> None:
    flights, work = Remembered[str](2), Work(BadScan("It cannot be made."))
    tasks = asked_at_once(flights, work, 3)
    work.go_on.set()
    for task in tasks:
        with pytest.raises(BadScan, match="cannot be made"):
            task.result(30)
    assert work.times == 1
    assert flights.result("key", lambda: "made after all") == "made after all"


def test_only_so_many_wait() -> None:
    flights, work = Remembered[str](2), Work()
    tasks = asked_at_once(flights, work, remembered.MOST_WAITING)
    with pytest.raises(TooMany) as refused:
        flights.result("key", work)
    assert refused.value.retry_after_s == remembered.RETRY_S
    work.go_on.set()
    assert {task.result(30) for task in tasks} == {"made 1"}
