"""One thread for linear algebra in each process: more are slower at this size, and fits would fight over the cores.

Which libraries have threads is found by looking through all that are loaded.  In a process that was forked just now
that takes 8 ms; so the fork server looks after its imports, and its children know.
"""

from threadpoolctl import ThreadpoolController, threadpool_limits

_libraries: ThreadpoolController | None = None


def look_for_libraries() -> None:
    """To be called in the fork server, whenever it has imported something."""
    global _libraries
    _libraries = ThreadpoolController()


def are_known() -> bool:
    """Whether this process, or the one that it was forked from, has looked."""
    return _libraries is not None


def use_one_thread() -> None:
    """From now on in this process."""
    if _libraries is None:
        threadpool_limits(1)
    else:
        _libraries.limit(limits=1)
