"""A 3D Slicer scene (.mrb): skin and scan as models, landmarks and lines as markups.

All is in mm along the patient's axes, left, back, head (LPS), and each file says so; Slicer turns it into its own RAS.
"""

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from breastrig.core.arrays import Array, Integers
from breastrig.core.notice import RESEARCH_USE_ONLY
from breastrig.core.srgb import rgb
from breastrig.geometry.polyline import Polyline
from breastrig.report.files.geometry_files import surface_ply

SCHEMA = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
COLOURS = {"skin": "0.35 0.55 0.85", "scan": "0.85 0.7 0.6"}
CURVES = {False: "Curve", True: "ClosedCurve"}  # by whether a line is closed
MARKUPS = "markups-schema-v1.0.3.json#"
FOLDER = "BreastRig"


def slicer_scene(
    surfaces: Mapping[str, tuple[Array, Integers]], landmarks: Mapping[str, Array], lines: Sequence[Polyline]
) -> bytes:
    """The archive, from (V, 3) m LPS vertices and (F, 3) triangles by name, (3,) m landmarks and lines, all LPS."""
    scene = Element("MRML", version="Slicer5.6", userTags="")
    files: dict[str, bytes] = {}

    def node(kind: str, number: int, name: str, file: str, content: bytes, **display: str) -> None:
        """A node with what displays and stores it."""
        base = "Markups" if kind.startswith("Markups") else kind
        stored = f"{base}Json" if base == "Markups" else base
        ids = {"display": f"vtkMRML{base}DisplayNode{number}", "storage": f"vtkMRML{stored}StorageNode{number}"}
        SubElement(scene, f"{base}Display", {"id": ids["display"], "name": f"{name} display", **display})
        place = f"Data/{file}"
        SubElement(
            scene, f"{stored}Storage", id=ids["storage"], name=f"{name} file", fileName=place, coordinateSystem="LPS"
        )
        references = "".join(f"{role}:{each};" for role, each in ids.items())
        SubElement(scene, kind, id=f"vtkMRML{kind}Node{number}", name=name, references=references)
        files[place] = content

    for number, (name, (vertices, faces)) in enumerate(surfaces.items(), 1):
        content = surface_ply(vertices, faces, 1e-3, "SPACE=LPS")
        opacity = "1.0" if name == "skin" else "0.5"
        node("Model", number, name, f"{name}.ply", content, color=COLOURS[name], opacity=opacity)
    places = [(name, point) for name, point in landmarks.items()]
    node("MarkupsFiducial", 1, "landmarks", "landmarks.mrk.json", _markup("Fiducial", places))
    for number, line in enumerate(lines, 2):
        points = [(f"{line.name}-{place}", point) for place, point in enumerate(line.points, 1)]
        kind, colour = CURVES[line.closed], " ".join(f"{each / 255:.3f}" for each in rgb(line.color))
        content = _markup(kind, points)
        node(f"Markups{kind}", number, line.name, f"line_{number - 1}.mrk.json", content, selectedColor=colour)
    indent(scene)
    files["BreastRig.mrml"] = tostring(scene, "UTF-8", xml_declaration=True)
    files["README.txt"] = f"{RESEARCH_USE_ONLY} mm, LPS: to the patient's left, back and head.\n".encode()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as bundle:
        for name, content in files.items():
            bundle.writestr(f"{FOLDER}/{name}", content)
    return packed.getvalue()


def _markup(kind: str, points: Sequence[tuple[str, Array]]) -> bytes:
    """A markups file of labelled (3,) m points."""
    control: list[dict[str, Any]] = [
        {"id": str(number), "label": label, "position": [round(1e3 * float(each), 4) for each in point], "locked": True}
        | {"positionStatus": "defined"}
        for number, (label, point) in enumerate(points, 1)
    ]
    markup = {
        "type": kind,
        "coordinateSystem": "LPS",
        "coordinateUnits": "mm",
        "locked": True,
        "controlPoints": control,
    }
    return json.dumps({"@schema": SCHEMA + MARKUPS, "markups": [markup]}, indent=1).encode()
