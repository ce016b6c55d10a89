"""An OBJ file's text, checked and made uniform before a library reads the file.

OBJ announces nothing, so a file that was cut off within its triangles looks whole to a library, which reads half a
body.  What gives it away: the last triangle lacks a corner; the file says how many there should be (MeshLab's do);
many points are left over that no triangle uses, or any at all where the last line has no end; or such a last number
seems to lack digits, because its triangle reaches far across the body.  A cut that leaves no such trace cannot be seen:
one exactly between two lines in which nearly all points are used already.
"""

import re
from functools import partial

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import MATERIALS

LEFT_OVER = 0.1  # share of the points that no triangle uses; scanning programs leave none or single ones
COMPARED = 50  # triangles before the last
FAR_REACHING = 3.0  # times the longest edge of those
INDENTED = re.compile(rb"(?m)^ +")
FACE = re.compile(rb"(?m)^f [^\n]*")
POLYGON = re.compile(rb"(?m)^f(?: +[^ \n]+){3}")
POINT = re.compile(rb"(?m)^v [^\n]*")
COLOURED = re.compile(rb"^v(?: +[^ \n]+){3}(?: +[^ \n]+){3,4} *$")  # x y z r g b, with an opacity sometimes
MATERIAL = re.compile(rb"(?m)^usemtl +([^\n]*)")
ANNOUNCED = re.compile(rb"(?m)^# *Faces: *(\d{1,9}) *$")  # in MeshLab's header
LARGE_POLYGON = re.compile(rb"(?m)^f [^\n]{20000}")
RELATIVE = re.compile(rb"(?m)^f [^\n]*-")  # corners counted backwards
BLOCK = re.compile(rb"(?m)(?:^f [^\n]*\n?)+")
COUNTED = (b"\nv ", b"\nvt ", b"\nvn ")  # what the three numbers of a corner count
WHOLE_CORNER = re.compile(rb" (-?\d{1,18}(?:/(?:-?\d{1,18})?){0,2})")
CORNER = re.compile(rb" (\d{1,18})")  # of a corner 12/13/14 the 12
LOOKED_AT = 4096  # bytes at the beginning, or the end
CUT_OFF = "This OBJ file ends in the middle of its triangles, as one that was cut off; export it again."
LOOSE = (
    "This OBJ file has many points without triangles, as one that was cut off; export it again, without loose points."
)


def uniform_text(data: bytes) -> bytes:
    """The same file in UTF-8, lines and words parted in one way, corners counted from the file's beginning."""
    data = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\t", b" ")
    try:
        data.decode()
    except UnicodeDecodeError:
        data = data.decode("latin-1").encode()
    data = INDENTED.sub(b"", data.replace(b"\\\n", b" "))
    return _counted_forwards(data) if RELATIVE.search(data) else data


def colours_as_shares(data: bytes) -> bytes:
    """A uniform text whose points have colours from 0 to 1, where they go to 255: both are written."""
    first = POINT.search(data)
    if first is None or not COLOURED.match(first[0]):
        return data
    words = [line.split()[4:7] for line in POINT.findall(data)]
    try:
        if max((float(word) for colour in words for word in colour), default=0.0) <= 1.0:
            return data
        return POINT.sub(_shares, data)
    except ValueError:
        return data  # no numbers: the reader finds out


def _shares(point: re.Match[bytes]) -> bytes:
    words = point[0].split()
    shares = [b"%.6f" % min(1.0, max(0.0, float(word) / 255.0)) for word in words[4:7]]
    return b" ".join([*words[:4], *shares])


def polygons(data: bytes) -> int:
    """How many polygons with at least three corners a uniform text holds."""
    return sum(1 for _ in POLYGON.finditer(data))


def check_work(data: bytes) -> None:
    """TooLarge for more materials, BadScan for larger polygons than any scan has: both take a reader long."""
    if LARGE_POLYGON.search(data):
        raise BadScan("This OBJ file has polygons with hundreds of corners; export it as triangles.")
    if data.count(b"usemtl") > MATERIALS and len(set(MATERIAL.findall(data))) > MATERIALS:
        raise TooLarge(f"This OBJ file uses more than the {MATERIALS} materials allowed; join them.")


def check_end(data: bytes, used: int) -> None:
    """BadScan for a uniform text that ends in the middle of its triangles.

    `used`: at most so many of its points belong to triangles, as far as the reader knows.
    """
    announced = ANNOUNCED.search(data[:LOOKED_AT])
    if announced is not None:
        if polygons(data) < int(announced[1]):
            raise BadScan(CUT_OFF)
        return
    last = next((line for line in reversed(data[-LOOKED_AT:].splitlines()) if line.strip()), b"").split()
    if not last or last[0] != b"f":
        return
    if len(last) < 4 or len({_form(corner) for corner in last[1:]}) > 1:
        raise BadScan(CUT_OFF)
    points = len(POINT.findall(data))
    if used < (1.0 - LEFT_OVER) * points:
        raise BadScan(LOOSE)
    if not data.endswith(b"\n") and (_used(data) < points or _lacks_digits(data, points)):
        raise BadScan(CUT_OFF)


def _form(corner: bytes) -> tuple[bool, ...]:
    """Which of the numbers of 12/13/14 are there."""
    return tuple(map(bool, corner.split(b"/")))


def _used(data: bytes) -> int:
    """How many points the triangles use."""
    return len({corner for face in FACE.finditer(data) for corner in CORNER.findall(face[0])})


def _lacks_digits(data: bytes, points: int) -> bool:
    """Whether the last number could have had another digit, and the triangle as it is reaches across the body."""
    faces = [CORNER.findall(line) for line in FACE.findall(data[-LOOKED_AT:])[-COMPARED - 1 :]]
    faces = [[int(corner) for corner in face] for face in faces]
    if faces[-1][-1] * 10 > points or len(faces) < 2:
        return False
    wanted = {corner for face in faces for corner in face}
    places: dict[int, Array] = {}
    for number, line in enumerate(POINT.finditer(data), start=1):
        if number in wanted:
            places[number] = np.array(line[0].split()[1:4], np.float64)
    edges = [
        max(float(np.linalg.norm(places[a] - places[b])) for a, b in zip(face, [*face[1:], face[0]], strict=True))
        for face in faces
    ]
    return edges[-1] > FAR_REACHING * max(edges[:-1])


def _counted_forwards(data: bytes) -> bytes:
    """Corners such as -1, the last one so far, by their number from the beginning."""
    parts, at, counts = [], 0, [0, 0, 0]
    for block in BLOCK.finditer(data):
        before = data[at : block.start()]
        lines = b"\n" + before
        counts = [count + lines.count(word) for count, word in zip(counts, COUNTED, strict=True)]
        parts += [before, WHOLE_CORNER.sub(partial(_forwards, counts), block[0])]
        at = block.end()
    return b"".join([*parts, data[at:]])


def _forwards(counts: list[int], corner: re.Match[bytes]) -> bytes:
    if b"-" not in corner[0]:
        return corner[0]
    numbers = corner[1].split(b"/")
    return b" " + b"/".join(
        b"%d" % (count + 1 + int(number)) if number.startswith(b"-") else number
        for number, count in zip(numbers, counts, strict=False)
    )
