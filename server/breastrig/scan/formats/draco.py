"""The primitives of a GLB that Draco compressed, by Draco's own decoder, which the extra `breastrig[formats]` brings.

What comes out is as hostile as an ordinary array: its indices are checked with those of all other files.
"""

from typing import Any

from breastrig.core.arrays import Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import TRIANGLES, VERTICES

EXTENSION = "KHR_draco_mesh_compression"
HOW_TO_OPEN = 'install "breastrig[formats]", or export it without compression'
KINDS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}  # glTF's numbers of numpy's types


def decoded(data: bytes) -> tuple[dict[int, Any], Integers]:
    """The attributes, as arrays by their numbers in the file, and the (F, 3) triangles.

    Raises BadScan or TooLarge with a sentence.
    """
    try:
        import DracoPy
    except ImportError:
        raise BadScan(f"This GLB file is compressed (Draco); {HOW_TO_OPEN}.") from None
    try:
        mesh = DracoPy.decode(data)
        faces = mesh.faces.astype("i8")
        attributes = {int(each["unique_id"]): each["data"] for each in mesh.attributes}
    except Exception as error:  # a decoder of untrusted bytes can raise anything
        raise BadScan("This GLB file is damaged: its Draco data cannot be unpacked; export it again.") from error
    if len(faces) > TRIANGLES or max(map(len, attributes.values()), default=0) > VERTICES:
        raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")
    return attributes, faces
