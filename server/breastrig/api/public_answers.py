"""Answers that show nobody: the page's own files and the model, compressed for browsers that take it.

They are few and never change while the service runs, so each is compressed once and kept.  What shows a patient is
not compressed: it is made for one reader, and the size of a compressed answer can tell of its content.
"""

import gzip
from functools import lru_cache

from flask import Response, request

from breastrig.api.answers import bytes_answer

FILES = 64  # the page has about thirty files, the model three
SMALL = 1000  # bytes; fewer are sent in one packet anyway


def public_answer(content: bytes, media_type: str, caching: str) -> Response:
    """As bytes_answer.  A range is of the content itself, so it is not compressed."""
    squeezes = len(content) >= SMALL and "Range" not in request.headers and request.accept_encodings["gzip"] > 0
    response = bytes_answer(_squeezed(content) if squeezes else content, media_type, caching)
    response.vary.add("Accept-Encoding")
    if squeezes:
        response.headers["Content-Encoding"] = "gzip"
        response.headers["Accept-Ranges"] = "none"
    return response


@lru_cache(maxsize=FILES)
def _squeezed(content: bytes) -> bytes:
    return gzip.compress(content, mtime=0)
