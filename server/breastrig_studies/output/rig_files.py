"""Rig -> torso.glb, torso.json, drawings/*.json.  The same rig gives the same bytes."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.gltf.side_file import (
    DRAWING_SCHEMA,
    RIG_SCHEMA,
    BoneEntry,
    CorrectiveEntry,
    FilePart,
    JointEntry,
    LandmarkEntry,
    ShapeEntry,
)
from breastrig.gltf.write_rig import GENERATOR, rig_glb
from breastrig.rig.model import ModelDrawing, Rig


def write_rig(
    rig: Rig,
    folder: Path,
    *,
    license: str = "CC0-1.0",
    provenance: Mapping[str, Any] | None = None,
    generator: str = GENERATOR,
) -> None:
    """Writes <name>.glb, <name>.json and drawings/<drawing>.json into `folder` (made when missing).

    `generator` is named in the header of the .glb.
    Raises BadModel when glTF cannot hold the rig (more than four bones on a vertex, several root bones).
    """
    (folder / "drawings").mkdir(parents=True, exist_ok=True)
    (folder / f"{rig.name}.glb").write_bytes(rig_glb(rig, generator))
    (folder / f"{rig.name}.json").write_bytes(_readable(_side_file(rig, license, provenance or {})))
    for drawing in rig.drawings:
        (folder / "drawings" / f"{drawing.name}.json").write_bytes(_readable(_drawing_file(drawing)))


def _side_file(rig: Rig, license: str, provenance: Mapping[str, Any]) -> dict[str, Any]:
    names = rig.bone_names
    correctives = [_entry(CorrectiveEntry, each, joint=names[rig.joints[each.joint].child]) for each in rig.correctives]
    return {
        "schema": RIG_SCHEMA,
        "name": rig.name,
        "license": license,
        "units": {"length": "m", "angle": "rad"},
        "up": "+Y",
        "front": "+Z",
        "bones": [
            _entry(BoneEntry, bone, parent=None if bone.parent is None else names[bone.parent]) for bone in rig.bones
        ],
        "joints": [
            _entry(JointEntry, joint, parent=names[joint.parent], child=names[joint.child]) for joint in rig.joints
        ],
        "shapes": [_entry(ShapeEntry, shape) for shape in rig.shapes],
        "landmarks": [_entry(LandmarkEntry, landmark) for landmark in rig.landmarks],
        "lengths": [
            {"name": length.name, "label": length.label, "from": length.start, "to": length.end}
            for length in rig.lengths
        ],
        **({} if rig.skinning == "linear" else {"skinning": rig.skinning}),
        **({"correctives": correctives} if correctives else {}),
        "drawings": list(rig.drawing_names),
        "regions": {name: vertices.tolist() for name, vertices in sorted(rig.regions.items())},
        "symmetry": {"vertices": rig.mirror_vertices.tolist()},
        "provenance": dict(provenance),
    }


def _entry(kind: type[FilePart], thing: object, **named: Any) -> dict[str, Any]:
    """A part of the rig as an entry of the side file; `named` are values that it gives by name instead of index."""
    values = {name: getattr(thing, name) for name in kind.model_fields} | named
    plain = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in values.items()}
    return kind.model_validate(plain).model_dump()


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
