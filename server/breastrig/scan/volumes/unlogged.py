"""Keeps libraries silent that read volumes: their warnings repeat values of headers, which belong in no log."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

LIBRARIES = ("pydicom", "nibabel.global")


@contextmanager
def unlogged() -> Iterator[None]:
    """What they warn of is neither logged nor shown."""
    loggers = [logging.getLogger(name) for name in LIBRARIES]
    before = [logger.disabled for logger in loggers]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            for logger in loggers:
                logger.disabled = True
            yield
        finally:
            for logger, was in zip(loggers, before, strict=True):
                logger.disabled = was
