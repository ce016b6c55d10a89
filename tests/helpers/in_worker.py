"""What a test asks a worker process to do; imported there by name."""

import gc
import os
import resource
import sys
import time

from threadpoolctl import threadpool_info

from breastrig.core.errors import BadScan, TooMany


def describe() -> dict[str, object]:
    """Limits and state of the process that runs this."""
    return {
        "pid": os.getpid(),
        "memory": resource.getrlimit(resource.RLIMIT_AS),
        "cpu": resource.getrlimit(resource.RLIMIT_CPU),
        "core": resource.getrlimit(resource.RLIMIT_CORE),
        "threads": sorted({pool["num_threads"] for pool in threadpool_info()}),
        "imported": sorted(sys.modules),
        "garbage": (gc.isenabled(), gc.get_freeze_count() > 1000),
    }


def burn() -> None:
    """Uses the processor without end."""
    while True:
        pass


def rest(seconds: float) -> None:
    time.sleep(seconds)


def wait_for(file: str) -> None:
    while not os.path.exists(file):
        time.sleep(0.005)


def refuse(sentence: str) -> None:
    raise BadScan(sentence)


def refuse_for_now(sentence: str, seconds: int) -> None:
    raise TooMany(sentence, seconds)


class Unpicklable(Exception):
    """Needs more than its text to be made again."""

    def __init__(self, one: str, two: str) -> None:
        super().__init__(one + two)


def raise_what_cannot_travel() -> None:
    raise Unpicklable("half ", "and half")


def die(signal_number: int) -> None:
    os.kill(os.getpid(), signal_number)


def sign_in_and_rest(file: str, seconds: float, answer: int) -> int:
    """Leaves the number of its process in a line of the file."""
    with open(file, "a") as signed:
        signed.write(f"{os.getpid()}\n")
    time.sleep(seconds)
    return answer


def sign_in_and_wait_for(file: str, end: str, answer: int) -> int:
    sign_in_and_rest(file, 0.0, answer)
    wait_for(end)
    return answer


def weigh(content: bytes) -> int:
    return len(content)


def note(file: str, text: str) -> None:
    """Adds a line to the file."""
    with open(file, "a", encoding="utf-8") as lines:
        lines.write(f"{text}\n")


def note_and_wait_for(file: str, text: str, end: str) -> None:
    note(file, text)
    wait_for(end)


_seen: list[str] = []


def remember(word: str) -> tuple[int, list[str]]:
    """This process, and all that it was asked to remember."""
    _seen.append(word)
    return os.getpid(), list(_seen)


def lose() -> None:
    """Ends the process as if the system had killed it."""
    os._exit(1)


def give_what_cannot_travel() -> object:
    return lambda: None


def fill(size: int) -> int:
    """Takes so much memory at once."""
    return len(bytearray(size))


def expire_soon() -> None:
    """The process rests for no time after this."""
    from breastrig.execution import worker

    worker.IDLE_S = 0.0
