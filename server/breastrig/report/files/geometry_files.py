"""Lines as OBJ and PLY polylines, and a surface as PLY and STL, in the unit that is asked for, for Blender and MeshLab.

Lines are text; a surface is in single precision where that is exact, else with more digits.  The STL comes from
trimesh, which takes 0.4 s to load, so it is loaded when one is written; a PLY is two arrays.
"""

from collections.abc import Sequence

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.notice import RESEARCH_USE_ONLY
from breastrig.core.single_precision import far_place
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


def surface_ply(vertices: Array, faces: Integers, metres_per_unit: float, comment: str = "") -> bytes:
    """A binary PLY of (V, 3) m vertices and (F, 3) triangles, with a comment in its header."""
    exact = not far_place(vertices).any()
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *([f"comment {comment}"] if comment else []),
        f"element vertex {len(vertices)}",
        *(f"property {'float' if exact else 'double'} {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    triangles = np.zeros(len(faces), [("count", "<u1"), ("corners", "<i4", 3)])
    triangles["count"], triangles["corners"] = 3, faces
    places = (vertices / metres_per_unit).astype("<f4" if exact else "<f8")
    return "\n".join(header).encode() + places.tobytes() + triangles.tobytes()


def surface_stl(vertices: Array, faces: Integers, metres_per_unit: float) -> bytes:
    """An STL of (V, 3) m vertices and (F, 3) triangles: binary, or text where that would round."""
    import trimesh

    mesh = trimesh.Trimesh(vertices / metres_per_unit, faces, process=False)
    if not far_place(vertices).any():
        return bytes(mesh.export(file_type="stl"))
    return str(mesh.export(file_type="stl_ascii")).encode()
