"""A drawing's lines as OBJ and PLY polylines: text, in the unit that is asked for, readable by Blender and MeshLab."""

from collections.abc import Sequence

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.notice import RESEARCH_USE_ONLY
from breastrig.core.srgb import rgb
from breastrig.geometry.polyline import Polyline


def obj_lines(lines: Sequence[Polyline], metres_per_unit: float, unit: str) -> bytes:
    """One named object with one `l` element for each line; a closed line comes back to its first point."""
    text = [f"# {RESEARCH_USE_ONLY}", f"# unit: {unit}, frame: the scan's"]
    count = 1
    for line in lines:
        text.append(f"o {line.name}")
        text += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in line.points / metres_per_unit]
        numbers = [*range(count, count + len(line.points)), *([count] if line.closed else [])]
        text.append("l " + " ".join(map(str, numbers)) if len(numbers) > 1 else f"p {count}")
        count += len(line.points)
    return ("\n".join(text) + "\n").encode()


def ply_lines(lines: Sequence[Polyline], metres_per_unit: float, unit: str) -> bytes:
    """Vertices with the number of their line and whether they are bridged, and edges with their line's colour."""
    points, edges = edges_of(lines)
    owner = np.repeat(np.arange(len(lines)), [len(line.points) for line in lines])
    bridged = np.concatenate([np.zeros(0, dtype=np.bool_), *(line.bridged for line in lines)])
    head = [
        "ply",
        "format ascii 1.0",
        f"comment {RESEARCH_USE_ONLY}",
        f"comment unit: {unit}, frame: the scan's",
        *(f"comment line {number}: {line.name}" for number, line in enumerate(lines)),
        f"element vertex {len(points)}",
        *(f"property double {axis}" for axis in "xyz"),
        "property int line",
        "property uchar bridged",
        f"element edge {len(edges)}",
        "property int vertex1",
        "property int vertex2",
        *(f"property uchar {name}" for name in ("red", "green", "blue")),
        "end_header",
    ]
    colours = [rgb(line.color) for line in lines]
    body = [
        f"{x:.6f} {y:.6f} {z:.6f} {line} {int(over_a_hole)}"
        for (x, y, z), line, over_a_hole in zip(points / metres_per_unit, owner, bridged, strict=True)
    ]
    body += [f"{a} {b} {' '.join(map(str, colours[owner[a]]))}" for a, b in edges]
    return ("\n".join([*head, *body]) + "\n").encode()


def edges_of(lines: Sequence[Polyline]) -> tuple[Array, Integers]:
    """((P, 3) m all points, (E, 2) edges between neighbours on a line)."""
    points = np.concatenate([np.zeros((0, 3)), *(line.points for line in lines)])
    edges, count = [np.zeros((0, 2), dtype=np.int64)], 0
    for line in lines:
        edges.append(count + line.edges)
        count += len(line)
    return points, np.concatenate(edges)
