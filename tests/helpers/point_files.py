"""A front of a body as a cloud of points, in files of every kind that hold such."""

import struct

import numpy as np

COLOURS = {"red": 0, "green": 1, "blue": 2}


def front(spacing: float = 0.004, hole: float = 0.0, height: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) m points of half an elliptic cylinder, `height` m high and 0.36 m wide, and their (N, 3) unit normals.

    Seen from +Z; a gap of `hole` m across its middle, all the way from left to right.
    """
    a, b = 0.18, 0.11
    fine = np.linspace(0.0, np.pi, 20_001)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(a * np.cos(fine)), np.diff(b * np.sin(fine))))])
    angles = np.interp(np.arange(0.0, length[-1], spacing), length, fine)
    levels = np.arange(0.0, height, spacing)
    levels = levels[np.abs(levels - height / 2.0) >= hole / 2.0]
    angle, y = (each.ravel() for each in np.meshgrid(angles, levels))
    normals = np.column_stack([np.cos(angle) / a, np.zeros_like(y), np.sin(angle) / b])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.column_stack([a * np.cos(angle), y - height / 2.0, b * np.sin(angle)]), normals


def colours_of(points: np.ndarray) -> np.ndarray:
    """(N, 3) bytes that change slowly over the body."""
    return np.round(255.0 * (points - points.min(axis=0)) / np.ptp(points, axis=0)).astype(np.uint8)


def pcd(points: np.ndarray, form: str = "binary", sensor: tuple[float, ...] = (0.0, 0.0, 0.0)) -> bytes:
    """Places and packed colours, as the Point Cloud Library writes them."""
    colour = colours_of(points).astype(np.uint32)
    packed = (colour[:, 0] << 16 | colour[:, 1] << 8 | colour[:, 2]).astype("<u4")
    columns = [*np.ascontiguousarray(points.T.astype("<f4")), packed]
    view = " ".join(map(str, sensor))
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\n"
        f"COUNT 1 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT {view} 1 0 0 0\nPOINTS {len(points)}\nDATA {form}\n"
    ).encode()
    if form == "ascii":
        rows = zip(*columns, strict=True)
        return header + "".join(f"{x:.9g} {y:.9g} {z:.9g} {rgb}\n" for x, y, z, rgb in rows).encode()
    if form == "binary":
        return header + b"".join(struct.pack("<fffI", *row) for row in zip(*columns, strict=True))
    content = b"".join(column.tobytes() for column in columns)
    packed_bytes = lzf(content)
    return header + struct.pack("<II", len(packed_bytes), len(content)) + packed_bytes


def lzf(content: bytes) -> bytes:
    """Packed as LZF allows: bytes as they are, and repetitions of four to eight bytes near before."""
    found, at, plain = bytearray(), 0, bytearray()

    def flush() -> None:
        for start in range(0, len(plain), 32):
            part = plain[start : start + 32]
            found.append(len(part) - 1)
            found.extend(part)
        plain.clear()

    seen: dict[bytes, int] = {}
    while at < len(content):
        four = content[at : at + 4]
        before = seen.get(four)
        seen[four] = at
        if len(four) == 4 and before is not None and at - before <= 8192:
            flush()
            back = at - before - 1
            found += bytes([(4 - 2) << 5 | back >> 8, back & 255])
            at += 4
        else:
            plain.append(content[at])
            at += 1
    flush()
    return bytes(found)


def point_ply(points: np.ndarray, normals: np.ndarray | None = None) -> bytes:
    """A PLY of places, colours and perhaps normals, with an empty list of triangles."""
    names = [*"xyz"] if normals is None else [*"xyz", "nx", "ny", "nz"]
    table = np.zeros(len(points), [*((name, "<f4") for name in names), *((name, "u1") for name in COLOURS)])
    for name, column in zip(names, np.column_stack([points, *([] if normals is None else [normals])]).T, strict=True):
        table[name] = column
    for name, index in COLOURS.items():
        table[name] = colours_of(points)[:, index]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    lines += [f"property float {name}" for name in names] + [f"property uchar {name}" for name in COLOURS]
    lines += ["element face 0", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(lines).encode() + table.tobytes()


def xyz(points: np.ndarray, form: str = "xyz rgb", comma: str = " ") -> bytes:
    """Rows of text: "xyz", "xyz rgb", "xyz intensity rgb" after a count, or "xyz normal"."""
    colours = colours_of(points)
    more = {
        "xyz": np.zeros((len(points), 0)),
        "xyz rgb": colours,
        "xyz intensity rgb": np.column_stack([np.linspace(-2047, 2047, len(points)).round(), colours]),
    }[form]
    rows = [comma.join(f"{number:.9g}" for number in row) for row in np.column_stack([points, more])]
    return ("\n".join(([str(len(points))] if "intensity" in form else []) + rows) + "\n").encode()
