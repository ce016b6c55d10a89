"""Unpacks .gz files, within limits."""

import gzip
import io
import zlib

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import GZIP_MEMBERS, LABEL_MAP_BYTES, MEBIBYTE

GZIP_START, MEMBER_START = b"\x1f\x8b", b"\x1f\x8b\x08"
TOO_MANY_PARTS = "This .gz file is packed in far too many parts; pack it again."
VOXELS_DAMAGED = "The voxels of this file are damaged or cut off; export it again."


def gunzipped(data: bytes) -> bytes:
    """The unpacked members of a .gz, joined.

    TooLarge beyond the limit of label maps, BadScan where it is damaged.
    """
    if data.count(MEMBER_START) > GZIP_MEMBERS:
        raise TooLarge(TOO_MANY_PARTS)
    try:
        whole = gzip.GzipFile(fileobj=io.BytesIO(data)).read(LABEL_MAP_BYTES + 1)
    except EOFError as error:
        raise BadScan("This .gz file is cut off; pack it again.") from error
    except (OSError, zlib.error) as error:
        raise BadScan("This .gz file is damaged; pack it again.") from error
    if len(whole) > LABEL_MAP_BYTES:
        raise TooLarge(f"This .gz file unpacks to more than the {LABEL_MAP_BYTES // MEBIBYTE} MB allowed.")
    return whole


def first_bytes(start: bytes) -> bytes:
    """The first unpacked bytes of a .gz from its beginning; empty where that is damaged."""
    try:
        return zlib.decompressobj(wbits=zlib.MAX_WBITS | 16).decompress(start, len(start))
    except zlib.error:
        return b""


def inflated(data: bytes, size: int) -> bytes:
    """The first `size` unpacked bytes of gzip or zlib data; BadScan where it is damaged or holds fewer."""
    if data.count(MEMBER_START) > GZIP_MEMBERS:
        raise TooLarge(TOO_MANY_PARTS)
    try:
        if data.startswith(GZIP_START):
            whole = gzip.GzipFile(fileobj=io.BytesIO(data)).read(size)
        else:
            whole = zlib.decompressobj().decompress(data, size)
    except (OSError, EOFError, zlib.error) as error:
        raise BadScan(VOXELS_DAMAGED) from error
    if len(whole) < size:
        raise BadScan(VOXELS_DAMAGED)
    return whole
