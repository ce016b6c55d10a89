"""How files are answered: with an ETag, with ranges, and with the caching that fits what they are.

Results never change once they are written, but they show a person's body, and DELETE must not be outlived: only
the browser that asked may keep them (`private`), and it must ask each time before it shows them again
(`no-cache`).  Most often the answer is a short 304; after a DELETE it is 404, and the copy is of no use.  The
model shows nobody and its address holds its hash: it may be kept for ever, by anyone.
"""

import hashlib
from pathlib import Path
from typing import Any

from flask import Response, request, send_file

FOR_EVER = "public, max-age=31536000, immutable"
PERSONAL = "private, no-cache"
CHECK_AGAIN = "no-cache"

GLB = "model/gltf-binary"
GLTF = "model/gltf+json"
JSON = "application/json"
BINARY = "application/octet-stream"
PDF = "application/pdf"


def file_of(media_type: str, description: str) -> dict[str, Any]:
    """A file as an answer of the API's description."""
    content = {media_type: {"schema": {"type": "string", "format": "binary"}}}
    return {"content": content, "description": description}


def file_answer(path: Path, media_type: str, caching: str, *, download_as: str | None = None) -> Response:
    """The file; 304 when the browser has it, 206 for a range."""
    response = send_file(
        path, media_type, conditional=True, as_attachment=download_as is not None, download_name=download_as
    )
    response.headers["Cache-Control"] = caching
    return response


def bytes_answer(content: bytes, media_type: str, caching: str) -> Response:
    """The same for content that was made in memory."""
    response = Response(content, mimetype=media_type)
    response.set_etag(hashlib.sha256(content).hexdigest()[:32])
    response.headers["Cache-Control"] = caching
    response.make_conditional(request, accept_ranges=True, complete_length=len(content))
    return response
