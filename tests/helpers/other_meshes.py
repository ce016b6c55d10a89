"""The tube of `mesh_variants` as OFF and 3MF."""

import numpy as np

from helpers.mesh_variants import FACES, UV, VERTICES
from helpers.scan_files import zipped

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"


def off(
    head: str = "OFF\n{points} {faces} 0\n",
    behind: np.ndarray | None = None,
    of_faces: np.ndarray | None = None,
    number: str = "{:.6f}",
) -> bytes:
    """With more numbers behind each point, and behind each triangle."""
    rows = VERTICES if behind is None else np.column_stack([VERTICES, behind])
    lines = [" ".join(number.format(each) for each in row) for row in rows]
    colours = [""] * len(FACES) if of_faces is None else [" ".join(f"{n:g}" for n in row) for row in of_faces]
    lines += [f"3 {a} {b} {c} {more}".rstrip() for (a, b, c), more in zip(FACES, colours, strict=True)]
    return (head.format(points=len(VERTICES), faces=len(FACES)) + "\n".join(lines) + "\n").encode()


def mesh_xml(triangle: str = "", scale: float = 1000.0, faces: np.ndarray = FACES) -> str:
    """A <mesh>; `triangle` has further attributes, of {k}, the triangle, and {a}, {b}, {c}, its corners."""
    vertices = "".join(f'<vertex x="{x:.5f}" y="{y:.5f}" z="{z:.5f}"/>' for x, y, z in scale * VERTICES)
    triangles = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}" {triangle.format(k=k, a=a, b=b, c=c)}/>'
        for k, (a, b, c) in enumerate(faces)
    )
    return f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"


def coordinates(group: int, picture: int) -> str:
    places = "".join(f'<m:tex2coord u="{u:.6f}" v="{v:.6f}"/>' for u, v in UV)
    return f'<m:texture2dgroup id="{group}" texid="{picture}">{places}</m:texture2dgroup>'


def colours(group: int, rows: np.ndarray) -> str:
    shown = "".join('<m:color color="#{:02X}{:02X}{:02X}FF"/>'.format(*row) for row in rows.tolist())
    return f'<m:colorgroup id="{group}">{shown}</m:colorgroup>'


def model_xml(resources: str, build: str = '<item objectid="1"/>', unit: str | None = "millimeter") -> bytes:
    named = "" if unit is None else f'unit="{unit}"'
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model {named} xml:lang="en-US" xmlns="{CORE}" '
        f'xmlns:m="{MATERIALS}" xmlns:p="{PRODUCTION}"><metadata name="Title">Anna</metadata>'
        f"<resources>{resources}</resources><build>{build}</build></model>"
    ).encode()


def three_mf(model: bytes, more: dict[str, bytes] | None = None) -> bytes:
    kinds = b'<?xml version="1.0"?><Types/>'
    return zipped({"[Content_Types].xml": kinds, "_rels/.rels": b"<r/>", "3D/3dmodel.model": model, **(more or {})})
