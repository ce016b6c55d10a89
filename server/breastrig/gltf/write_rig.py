"""Rig -> torso.glb, torso.json, drawings/*.json.  The same rig gives the same bytes."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from breastrig.gltf.container import BufferWriter, new_document, to_glb
from breastrig.gltf.side_file import DRAWING_SCHEMA, RIG_SCHEMA
from breastrig.gltf.skinned import add_skinned_rig, set_pose
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import rest_parameters


def write_rig(rig: Rig, folder: Path, *, license: str = "CC0-1.0", provenance: Mapping[str, Any] | None = None) -> None:
    """Writes <name>.glb, <name>.json and drawings/<drawing>.json into `folder` (made when missing).

    Raises BadModel when glTF cannot hold the rig (more than four bones on a vertex, several root bones).
    """
    (folder / "drawings").mkdir(parents=True, exist_ok=True)
    (folder / f"{rig.name}.glb").write_bytes(rig_glb(rig))
    (folder / f"{rig.name}.json").write_bytes(_readable(_side_file(rig, license, provenance or {})))
    for drawing in rig.drawings:
        (folder / "drawings" / f"{drawing.name}.json").write_bytes(_readable(_drawing_file(drawing)))


def rig_glb(rig: Rig) -> bytes:
    """The rig at rest as one .glb."""
    document = new_document()
    buffer = BufferWriter(document)
    skinned = add_skinned_rig(document, buffer, rig)
    set_pose(document, skinned, rig, rest_parameters(rig))
    return to_glb(document, buffer)


def _side_file(rig: Rig, license: str, provenance: Mapping[str, Any]) -> dict[str, Any]:
    names = rig.bone_names
    return {
        "schema": RIG_SCHEMA,
        "name": rig.name,
        "license": license,
        "units": {"length": "m", "angle": "rad"},
        "up": "+Y",
        "front": "+Z",
        "bones": [
            {
                "name": bone.name,
                "parent": None if bone.parent is None else names[bone.parent],
                "scale_min": bone.scale_min.tolist(),
                "scale_max": bone.scale_max.tolist(),
                "mirror": bone.mirror,
            }
            for bone in rig.bones
        ],
        "joints": [
            {
                "parent": names[joint.parent],
                "child": names[joint.child],
                "anchor": joint.anchor.tolist(),
                "rotation_sigma": float(joint.rotation_sigma),
                "translation_sigma": float(joint.translation_sigma),
                "rotation_limit": float(joint.rotation_limit),
            }
            for joint in rig.joints
        ],
        "shapes": [
            {
                "name": shape.name,
                "label": shape.label,
                "kind": shape.kind,
                "min": float(shape.min),
                "max": float(shape.max),
                "sigma": float(shape.sigma),
                "mirror": shape.mirror,
            }
            for shape in rig.shapes
        ],
        "landmarks": [
            {
                "name": landmark.name,
                "label": landmark.label,
                "latin": landmark.latin,
                "definition": landmark.definition,
                "easy": landmark.easy,
                "mirror": landmark.mirror,
                "face": int(landmark.face),
                "barycentric": landmark.barycentric.tolist(),
            }
            for landmark in rig.landmarks
        ],
        "lengths": [
            {"name": length.name, "label": length.label, "from": length.start, "to": length.end}
            for length in rig.lengths
        ],
        "drawings": list(rig.drawing_names),
        "regions": {name: vertices.tolist() for name, vertices in sorted(rig.regions.items())},
        "symmetry": {"vertices": rig.mirror_vertices.tolist()},
        "provenance": dict(provenance),
    }


def _drawing_file(drawing: ModelDrawing) -> dict[str, Any]:
    return {
        "schema": DRAWING_SCHEMA,
        "name": drawing.name,
        "label": drawing.label,
        "shapes": [
            {
                "name": shape.name,
                "label": shape.label,
                "closed": shape.closed,
                "color": shape.color,
                "surface_points": [
                    {"face": int(face), "barycentric": barycentric.tolist()}
                    for face, barycentric in zip(shape.points.faces, shape.points.barycentric, strict=True)
                ],
                **({"corners": list(shape.corners)} if shape.corners else {}),
            }
            for shape in drawing.shapes
        ],
    }


def _readable(document: dict[str, Any]) -> bytes:
    """JSON with one line for each entry of the top lists: short in a diff, readable in an editor."""
    lines = []
    for key, value in document.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = ",\n".join(f"  {_compact(row)}" for row in value)
            lines.append(f" {_compact(key)}: [\n{rows}\n ]")
        elif isinstance(value, dict) and value:
            rows = ",\n".join(f"  {_compact(name)}: {_compact(row)}" for name, row in value.items())
            lines.append(f" {_compact(key)}: {{\n{rows}\n }}")
        else:
            lines.append(f" {_compact(key)}: {_compact(value)}")
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode()


def _compact(value: Any) -> str:
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
