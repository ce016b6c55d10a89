"""One BLAS thread while a fit computes: more are slower at this size, and the last digits would wander."""

from contextlib import AbstractContextManager
from functools import cache
from typing import Any

import scipy.linalg  # noqa: F401  loads SciPy's own BLAS, so that the controller finds it too
from threadpoolctl import ThreadpoolController


def one_thread() -> AbstractContextManager[Any]:
    """For the block; afterwards there are as many as before."""
    limit: AbstractContextManager[Any] = _controller().limit(limits=1)
    return limit


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()  # looking for the libraries takes milliseconds, limiting them microseconds
