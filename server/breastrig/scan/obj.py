"""An OBJ file's text, checked and made uniform before a library reads the file.

OBJ announces nothing, so a file that was cut off within its triangles looks whole to a library, which reads half a
body.  What gives it away: the last triangle lacks a corner; the file says how many there should be (MeshLab's do);
points are left over that no triangle uses; or, without a line end, the last number seems to lack digits, because the
last triangle reaches far across the body.  A cut that leaves no such trace cannot be seen.
"""

import re

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
MATERIAL = re.compile(rb"(?m)^usemtl +([^\n]*)")
ANNOUNCED = re.compile(rb"(?m)^# *Faces: *(\d{1,9}) *$")  # in MeshLab's header
RELATIVE = re.compile(rb"(?m)^f [^\n]*-")  # corners counted backwards
CORNER = re.compile(rb" (\d{1,18})")  # of a corner 12/13/14 the 12
LOOKED_AT = 4096  # bytes at the beginning, or the end
CUT_OFF = "This OBJ file ends in the middle of its triangles, as one that was cut off; export it again."


def uniform_text(data: bytes) -> bytes:
    """The same file in UTF-8, lines and words parted in one way, corners counted from the file's beginning."""
    data = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\t", b" ")
    try:
        data.decode()
    except UnicodeDecodeError:
        data = data.decode("latin-1").encode()
    data = INDENTED.sub(b"", data.replace(b"\\\n", b" "))
    return _counted_forwards(data) if RELATIVE.search(data) else data


def polygons(data: bytes) -> int:
    """How many polygons with at least three corners a uniform text holds."""
    return sum(1 for _ in POLYGON.finditer(data))


def check_materials(data: bytes) -> None:
    """TooLarge when the triangles are split by more materials than any scan has."""
    if data.count(b"usemtl") > MATERIALS and len(set(MATERIAL.findall(data))) > MATERIALS:
        raise TooLarge(f"This OBJ file uses more than the {MATERIALS} materials allowed; join them.")


def check_end(data: bytes, used: int) -> None:
    """BadScan for a uniform text that ends in the middle of its triangles.

    `used`: at most so many of its points belong to triangles, as far as the reader knows.
    """
    announced = ANNOUNCED.search(data[:LOOKED_AT])
    if announced is not None and polygons(data) < int(announced[1]):
        raise BadScan(CUT_OFF)
    last = next((line for line in reversed(data[-LOOKED_AT:].splitlines()) if line.strip()), b"").split()
    if not last or last[0] != b"f":
        return
    if len(last) < 4 or len({_form(corner) for corner in last[1:]}) > 1:
        raise BadScan(CUT_OFF)
    points = len(POINT.findall(data))
    if used < (1.0 - LEFT_OVER) * points:
        raise BadScan(CUT_OFF)
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
    counts = {b"v": 0, b"vt": 0, b"vn": 0}
    lines = data.split(b"\n")
    for index, line in enumerate(lines):
        words = line.split()
        if not words:
            continue
        if words[0] in counts:
            counts[words[0]] += 1
        elif words[0] == b"f" and b"-" in line:
            lines[index] = b" ".join([b"f", *(_forwards(corner, tuple(counts.values())) for corner in words[1:])])
    return b"\n".join(lines)


def _forwards(corner: bytes, counts: tuple[int, ...]) -> bytes:
    numbers = corner.split(b"/")
    return b"/".join(
        b"%d" % (count + 1 + int(number)) if re.fullmatch(rb"-\d{1,18}", number) else number
        for number, count in zip(numbers, counts, strict=False)
    )
