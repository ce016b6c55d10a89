"""Processes that keep one thing at hand: limits, answers, refusals, and their end."""

import os
import signal
from collections.abc import Iterator
from threading import Timer

import pytest
from helpers import in_worker
from helpers.waiting import until

from breastrig.core.errors import FitFailed
from breastrig.execution.warm_process import WarmProcess

GIB = 2**30


@pytest.fixture
def counter() -> Iterator[WarmProcess]:
    """Answers with its number and the sum of all that it was asked."""
    process = WarmProcess(in_worker.open_sum, (100,), 4 * GIB)
    process.opened(60.0)
    yield process
    process.end()


def gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def test_it_keeps_what_it_has_opened_from_question_to_question(counter: WarmProcess) -> None:
    first, second = (counter.answer(number, 30.0).split() for number in (b"1", b"20"))
    assert (first[1], second[1]) == (b"101", b"121")
    assert first[0] == second[0] != str(os.getpid()).encode()
    assert int(first[2]) == 4 * GIB


def test_a_refusal_is_its_sentence_and_not_its_end(counter: WarmProcess) -> None:
    with pytest.raises(FitFailed, match=r"^no number\.$"):
        counter.answer(b"none", 30.0)
    assert counter.answer(b"3", 30.0).split()[1] == b"103"


def test_what_cannot_be_opened_says_why() -> None:
    process = WarmProcess(in_worker.open_sum, (None,), 4 * GIB)
    with pytest.raises(FitFailed, match=r"^nothing to begin with\.$"):
        process.opened(60.0)
    until(lambda: not process.is_alive, "the process to end")


@pytest.mark.parametrize("how", ["killed", "slow"])
def test_one_that_dies_or_gives_no_answer_is_over_for_good(counter: WarmProcess, how: str) -> None:
    pid = int(counter.answer(b"0", 30.0).split()[0])
    if how == "killed":
        os.kill(pid, signal.SIGKILL)
    with pytest.raises(OSError):  # noqa: PT011 TimeoutError, or the system's own word
        counter.answer(b"sleep", 0.2)
    assert not counter.is_alive
    until(lambda: gone(pid), "the process to be gone")
    with pytest.raises(OSError):  # noqa: PT011
        counter.answer(b"0", 0.2)


def test_ending_it_while_somebody_waits_wakes_them(counter: WarmProcess) -> None:
    timer = Timer(0.3, counter.end)
    timer.start()
    with pytest.raises(OSError):  # noqa: PT011
        counter.answer(b"sleep", 60.0)
    timer.join()
    assert not counter.is_alive
