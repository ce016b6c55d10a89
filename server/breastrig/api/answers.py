"""Answers files: with an ETag, with ranges, and with caching and compression by their kind.

Files that show a patient are cached nowhere (`no-store`): no copy may outlive DELETE, not even on the disk of the
browser that asked. The model shows nobody and its address holds its hash: it may be cached for ever, by anyone.

The page's own files and the model are compressed for browsers that accept it. They are few and never change while the
service runs, so each is compressed once and cached. Files that show a patient are not compressed: they are made for one
reader, and the size of a compressed answer can reveal its content.
"""

import gzip
import hashlib
import io
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import lru_cache
from typing import IO, Any

from flask import Response, after_this_request, request, send_file
from werkzeug.wsgi import wrap_file

from breastrig.core.errors import NotFound
from breastrig.storage.files import OpenedFile

FOR_EVER = "public, max-age=31536000, immutable"
PERSONAL = "no-store"
CHECK_AGAIN = "no-cache"

GLB = "model/gltf-binary"
GLTF = "model/gltf+json"
JSON = "application/json"
BINARY = "application/octet-stream"
PDF = "application/pdf"
STL = "model/stl"
VTU = "application/vnd.vtk.vtu"
PNG = "image/png"
CSV = "text/csv"
ZIP = "application/zip"

PUBLIC_FILES = 64  # the page has about thirty files, the model three
CHUNK_BYTES = 2**16  # read of a file at a time
ONE_PACKET = 1000  # bytes; an answer with fewer is sent in one packet anyway


def file_of(media_type: str, description: str) -> Any:
    """A file as an answer of the API's description; APIFlask's own types know no such thing.

    Generators of clients keep the body of a media type that they know: every one knows plain bytes, text and JSON.
    """
    if media_type.endswith("+json"):
        schema = {"type": "object"}
    elif media_type.startswith("text/"):
        schema = {"type": "string"}
    else:
        schema = {"type": "string", "format": "binary"}
    known = dict.fromkeys((media_type, BINARY)) if "format" in schema else (media_type,)
    return {"content": {one: {"schema": schema} for one in known}, "description": description}


def media_type_of(name: str) -> str:
    """Of a fit's or a link's file, by the ending of its name."""
    return {".json": JSON, ".glb": GLB, ".pdf": PDF}.get(name[name.rindex(".") :], BINARY)


def browser_forgets() -> None:
    """In a view that deletes: its answer, an error too, has the browser drop whatever it has kept all the same."""

    @after_this_request
    def forget(response: Response) -> Response:
        response.headers["Clear-Site-Data"] = '"cache"'
        return response


def in_memory(content: bytes) -> OpenedFile:
    """Content made for an answer, as a file."""
    return OpenedFile(None, len(content), hashlib.sha256(content).hexdigest()[:32], lambda: io.BytesIO(content))


def file_answer(file: OpenedFile, media_type: str, caching: str) -> Response:
    """The file; 304 when the browser has it, 206 for a range."""
    if file.path is not None:
        response = send_file(file.path, media_type, conditional=True, etag=file.etag)
    else:
        response = streamed_answer(file, media_type)
    response.headers["Cache-Control"] = caching
    return response


def streamed_answer(
    file: OpenedFile, media_type: str, guarded: Callable[[Any], Any] = lambda opened: opened
) -> Response:
    """The file as by `file_answer`, read through `guarded` while it is sent, and opened only when some of it is wanted.

    Raises NotFound when it is gone.
    """
    if request.if_none_match.contains_weak(file.etag):
        response = Response(status=304)
        response.set_etag(file.etag)
        return response
    with ExitStack() as stack:
        body = wrap_file(request.environ, guarded(stack.enter_context(closing(opened(file)))), CHUNK_BYTES)
        response = Response(body, mimetype=media_type)
        response.content_length = file.size
        response.set_etag(file.etag)
        response.make_conditional(request, accept_ranges=True, complete_length=file.size)
        response.call_on_close(stack.pop_all().close)
    return response


def opened(file: OpenedFile) -> IO[bytes]:
    """The opened file. Raises NotFound when it was deleted meanwhile."""
    try:
        return file.open()
    except FileNotFoundError as error:
        raise NotFound("This file has just been deleted.") from error


def bytes_answer(content: bytes, media_type: str, caching: str) -> Response:
    """The answer for content that was made in memory."""
    return file_answer(in_memory(content), media_type, caching)


def public_answer(content: bytes, media_type: str, caching: str) -> Response:
    """The answer for content that shows nobody, compressed; not for a range, which is of the content itself."""
    compresses = len(content) >= ONE_PACKET and "Range" not in request.headers and request.accept_encodings["gzip"] > 0
    response = bytes_answer(_compressed(content) if compresses else content, media_type, caching)
    response.vary.add("Accept-Encoding")
    if compresses:
        response.headers["Content-Encoding"] = "gzip"
        response.headers["Accept-Ranges"] = "none"
    return response


@lru_cache(maxsize=PUBLIC_FILES)
def _compressed(content: bytes) -> bytes:
    return gzip.compress(content, mtime=0)
