"""Pictures inside scans: only JPEG and PNG, never too large, written anew without their metadata."""

import io
import warnings

from PIL import Image

from breastrig.core.errors import TooLarge
from breastrig.scan.limits import IMAGE_PIXELS, TEXTURE_SIDE

FORMATS = ("JPEG", "PNG")
MARKS = (b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n")
QUALITY = 90  # JPEG


def is_picture(data: bytes) -> bool:
    """Whether these bytes are a JPEG or PNG whose header can be read; TooLarge when it has too many pixels."""
    if not data.startswith(MARKS):
        return False
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data), formats=FORMATS) as picture:
                width, height = picture.size
    except Image.DecompressionBombError as error:
        raise _too_large() from error
    except Exception:  # whatever a broken picture does to its decoder, it is no picture
        return False
    if width * height > IMAGE_PIXELS:
        raise _too_large()
    return True


def written_anew(picture: Image.Image) -> bytes | None:
    """A JPEG of at most TEXTURE_SIDE pixels a side without metadata; None when the picture cannot be decoded."""
    if picture.width * picture.height > IMAGE_PIXELS:
        raise _too_large()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            picture.draft("RGB", (TEXTURE_SIDE, TEXTURE_SIDE))
            plain = picture.convert("RGB")
            plain.thumbnail((TEXTURE_SIDE, TEXTURE_SIDE))
            clean = Image.new("RGB", plain.size)
            clean.paste(plain)
            stream = io.BytesIO()
            clean.save(stream, "JPEG", quality=QUALITY)
    except Exception:
        return None
    return stream.getvalue()


def _too_large() -> TooLarge:
    return TooLarge(
        f"A picture of this scan has more than {IMAGE_PIXELS // 10**6} million pixels; scale it down first."
    )
