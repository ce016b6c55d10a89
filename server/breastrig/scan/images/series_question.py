"""Asks which of several series is the scan."""

import base64
import io
from typing import Any

import numpy as np
from PIL import Image

from breastrig.core.errors import NeedsAnswer
from breastrig.scan.images.dicom_pixels import middle_of
from breastrig.scan.images.dicom_series import Stack
from breastrig.scan.volumes.codes import label_of

PIXELS = 160  # of a picture's longer side
PLANES = ("sagittal", "coronal", "axial")  # by the axis across them
SEVERAL = "These DICOM files hold several series that show a volume"
DARKEST, LIGHTEST = 1.0, 99.5  # percentiles that become black and white


def which_series(stacks: list[Stack]) -> NeedsAnswer:
    """The error that asks, with its choices."""
    choices = []
    for each in stacks:
        choice: dict[str, Any] = {"value": each.value, "text": described(each)}
        if (picture := _picture(each)) is not None:
            choice["picture"] = picture
        choices.append(choice)
    return NeedsAnswer(SEVERAL, {"field": "series", "choices": choices})


def described(stack: Stack) -> str:
    """Plane, matrix, spacing and count of slices, and the header's own words."""
    sizes = np.linalg.norm(stack.affine[:3, :3], axis=0)
    normal = np.cross(stack.affine[:3, 0], stack.affine[:3, 1])
    words = label_of([stack.slices[0].words])
    facts = [
        f"{PLANES[int(np.abs(normal).argmax())]}, {len(stack.slices)} slices {sizes[2]:.3g} mm apart",
        f"{stack.shape[0]} x {stack.shape[1]} pixels of {sizes[0]:.3g} x {sizes[1]:.3g} mm",
        *([stack.part] if stack.part else []),
        *([f'"{words}"'] if words else []),
    ]
    return ", ".join(facts)


def _picture(stack: Stack) -> str | None:
    """The slice in the middle: a PNG as data address."""
    pixels = middle_of(stack)
    if pixels is None:
        return None
    low, high = np.percentile(pixels, (DARKEST, LIGHTEST))
    grey = np.clip((pixels.astype(np.float32) - low) * (255.0 / max(float(high - low), 1e-6)), 0.0, 255.0)
    sizes = np.linalg.norm(stack.affine[:3, :2], axis=0) * grey.shape[::-1]
    width, height = (max(16, round(PIXELS * each / sizes.max())) for each in sizes)
    stream = io.BytesIO()
    Image.fromarray(grey.astype(np.uint8)).resize((width, height)).save(stream, "PNG")
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()
