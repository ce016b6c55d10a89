"""Pictures inside scans, never too large, kept without what is not picture.

A picture can say where and when it was taken, by which camera, and carry a second picture of the room.  Of a JPEG
or PNG the parts that make its pixels are kept, byte for byte, and nothing else; other kinds, and numbers of more than
eight bits, are written as PNG.  Colour profiles go too, which glTF says are to be ignored, and so does the camera's
word on which side is up: texture coordinates count the pixels as they are stored, for modelling programs (Blender among
them) and Pillow do.  Browsers turn such a picture, so it is spoken of.
"""

import io
import re
import struct
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import IMAGE_PIXELS, JPEG_PASSES, TEXTURE_SIDE
from breastrig.scan.piece import colour_bytes

if TYPE_CHECKING:
    from PIL.Image import Image

FORMATS = ("JPEG", "PNG", "WEBP", "TIFF", "BMP", "GIF", "AVIF", "TGA")  # the last has no mark of its own
EIGHT_BITS = ("1", "L", "LA", "P", "PA", "RGB", "RGBA")  # Pillow's modes
PNG_MARK = b"\x89PNG\r\n\x1a\n"
QUALITY = 90  # JPEG
TURNED = (
    "A picture of this scan says that it was taken with the camera turned; its pixels were used as they are stored. "
    "If the colours lie wrongly on the skin, save the picture upright and export the scan again."
)
ORIENTATION, UPRIGHT = 0x0112, 1  # EXIF's tag, and its value for a picture that is stored as it is seen
LEFT_OUT = "The texture is of a kind that is not read here, or damaged, and was left out."

PNG_KEPT = (b"IHDR", b"PLTE", b"tRNS", b"IDAT", b"IEND")
JPEG_FRAMES = {*range(0xC0, 0xD0), 0xDB, 0xDC, 0xDD} - {0xC8}  # size and components, tables, lines, restarts
JFIF, ADOBE, SCAN, END = 0xE0, 0xEE, 0xDA, 0xD9
IN_SCAN = re.compile(rb"\xff[^\x00\xff\xd0-\xd7]")  # the first marker after compressed data


@contextmanager
def opened(data: bytes) -> Iterator["Image"]:
    """The picture, not decoded yet.  Raises TooLarge when it has too many pixels, BadScan when it is none."""
    from PIL import Image  # it takes longer to load than a scan to read, and a fit looks at no picture

    Image.init()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            picture = Image.open(io.BytesIO(data), formats=[each for each in FORMATS if each in Image.OPEN])
        except Image.DecompressionBombError as error:
            raise _too_large() from error
        except Exception as error:  # whatever a broken picture does to its decoder, it is no picture
            raise BadScan(LEFT_OUT) from error
        with picture:
            if picture.width * picture.height > IMAGE_PIXELS:
                raise _too_large()
            yield picture


def plain_picture(data: bytes) -> bytes | None:
    """A JPEG or PNG of the same pixels and nothing else; None for what is no sound picture.

    Raises TooLarge when it has too many pixels.
    """
    try:
        with opened(data) as picture:
            if picture.format == "JPEG":
                return _plain_jpeg(data)
            if picture.format == "PNG" and picture.mode in EIGHT_BITS:
                return _plain_png(data)
            return _as_png(picture)
    except TooLarge:
        raise
    except Exception:  # as above
        return None


def is_turned(data: bytes) -> bool:
    """Whether these bytes, which are a picture, say that they are to be turned or mirrored to be upright."""
    try:
        with opened(data) as picture:
            return picture.format != "TIFF" and bool(picture.getexif().get(ORIENTATION, UPRIGHT) != UPRIGHT)
    except Exception:  # metadata is as hostile as the rest, and nobody needs it
        return False


def written_anew(data: bytes) -> bytes | None:
    """A JPEG of at most TEXTURE_SIDE pixels a side without metadata; None when the picture cannot be decoded."""
    from PIL import Image  # as above

    try:
        with opened(data) as picture:
            picture.draft("RGB", (TEXTURE_SIDE, TEXTURE_SIDE))
            plain = picture.convert("RGB")
        plain.thumbnail((TEXTURE_SIDE, TEXTURE_SIDE))
        clean = Image.new("RGB", plain.size)
        clean.paste(plain)
        stream = io.BytesIO()
        clean.save(stream, "JPEG", quality=QUALITY)
    except TooLarge:
        raise
    except Exception:
        return None
    return stream.getvalue()


def pixels_of(data: bytes) -> NDArray[np.uint8]:
    """(H, W, 3) sRGB of at most TEXTURE_SIDE a side.  Raises BadScan for a picture that cannot be decoded, TooLarge.

    The file's own picture is better than the one written anew: thin lines lose contrast with each writing.
    """
    try:
        with opened(data) as picture:
            factor = -(-max(picture.size) // TEXTURE_SIDE)
            plain = picture.convert("RGB")
            return np.asarray(plain.reduce(factor) if factor > 1 else plain)
    except TooLarge:
        raise
    except Exception as error:  # whatever a broken picture does to its decoder
        raise BadScan("The texture of this scan cannot be decoded; export it again.") from error


def _as_png(picture: "Image") -> bytes:
    """The picture's first frame as PNG with eight bits."""
    from PIL import Image  # as above

    if picture.mode.startswith(("I", "F")):
        full = 65535.0 if picture.mode.startswith("I;16") else None
        plain = Image.fromarray(colour_bytes(np.asarray(picture, dtype=np.float64), full))
    else:
        plain = picture.convert("RGB")
    stream = io.BytesIO()
    plain.save(stream, "PNG", compress_level=1)
    return _plain_png(stream.getvalue())


def _plain_png(data: bytes) -> bytes:
    """IHDR to IEND; names of chunks that are neither pixels, palette nor transparency are dropped with them."""
    kept, at = [PNG_MARK], len(PNG_MARK)
    while True:
        length, kind = struct.unpack_from(">I4s", data, at)
        chunk = data[at : at + 12 + length]
        if len(chunk) != 12 + length:
            raise ValueError("cut off")
        if kind in PNG_KEPT:
            kept.append(chunk)
        if kind == b"IEND":
            return b"".join(kept)
        at += len(chunk)


def _plain_jpeg(data: bytes) -> bytes:
    """The JPEG reduced to its frames, tables and scans, without metadata.

    Two application markers stay because they define the colour space: JFIF, without its small preview, and Adobe's.
    """
    kept, at, passes = [data[:2]], 2, 0
    while True:
        if data[at] != 0xFF:
            raise ValueError("no marker")
        marker = data[at + 1]
        if marker == 0xFF:  # filling
            at += 1
            continue
        if marker == END:
            return b"".join([*kept, data[at : at + 2]])
        (length,) = struct.unpack_from(">H", data, at + 2)
        segment = data[at : at + 2 + length]
        if length < 2 or len(segment) != 2 + length:
            raise ValueError("cut off")
        at += len(segment)
        if marker in JPEG_FRAMES:
            kept.append(segment)
        elif marker == JFIF and segment[4:9] == b"JFIF\0" and length >= 16:
            kept.append(struct.pack(">2BH", 0xFF, JFIF, 16) + segment[4:16] + b"\0\0")
        elif marker == ADOBE and segment[4:9] == b"Adobe" and length == 14:
            kept.append(segment)
        elif marker == SCAN:
            passes += 1
            found = IN_SCAN.search(data, at)
            if found is None or passes > JPEG_PASSES:
                raise ValueError("cut off, or endless")
            kept += [segment, data[at : found.start()]]
            at = found.start()


def _too_large() -> TooLarge:
    return TooLarge(
        f"A picture of this scan has more than {IMAGE_PIXELS // 10**6} million pixels; scale it down first."
    )
