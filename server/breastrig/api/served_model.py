"""The model as the service hands it out: read once, when the service starts.

What writes glTF is imported where it is first asked for: it takes a tenth of a second of each start.
"""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import ModelDrawing, Rig


@dataclass(frozen=True, eq=False)
class ServedModel:
    """One rig with the bytes that belong to it."""

    rig: Rig
    on_disk: bytes
    file: Path
    side: dict[str, Any]  # the side file as it is on disk

    def is_still_there(self) -> bool:
        """Whether workers, who read the file for each fit, find the same one."""
        try:
            return self.file.read_bytes() == self.on_disk
        except OSError:
            return False

    @cached_property
    def glb(self) -> bytes:
        """Written anew: nodes as a fit poses them, whatever the file calls its bones' sizes."""
        from breastrig.gltf.write_rig import rig_glb

        return rig_glb(self.rig)

    @cached_property
    def side_json(self) -> bytes:
        """The side file with the drawings and the order of the morph targets merged in."""
        merged = {
            **self.side,
            "shape_names": list(self.rig.shape_names),
            "drawings": [_drawing(drawing) for drawing in self.rig.drawings],
        }
        return json.dumps(merged, separators=(",", ":")).encode()

    @cached_property
    def buffer(self) -> bytes:
        from breastrig.gltf.iterate import model_buffer

        return model_buffer(self.rig)

    @cached_property
    def drawing_buffers(self) -> dict[str, bytes]:
        from breastrig.gltf.iterate import drawing_buffer

        return {drawing.name: drawing_buffer(self.rig, drawing) for drawing in self.rig.drawings}

    @property
    def buffer_link(self) -> str:
        return f"/api/models/{self.rig.sha256}/torso.bin"

    def drawing_link(self, name: str) -> str:
        return f"/api/models/{self.rig.sha256}/drawings/{name}.bin"


def serve_model(path: Path | None = None) -> ServedModel:
    """Reads the rig at `path` (None: the packaged one).  Raises BadModel with a sentence."""
    glb = path or default_rig_path()
    rig = read_rig(glb)
    return ServedModel(rig, glb.read_bytes(), glb, json.loads(glb.with_suffix(".json").read_text(encoding="utf-8")))


def _drawing(drawing: ModelDrawing) -> dict[str, Any]:
    shapes = [
        {
            "name": shape.name,
            "label": shape.label,
            "closed": shape.closed,
            "color": shape.color,
            "surface_points": [
                {"face": int(face), "barycentric": [float(weight) for weight in weights]}
                for face, weights in zip(shape.points.faces, shape.points.barycentric, strict=True)
            ],
        }
        for shape in drawing.shapes
    ]
    return {"name": drawing.name, "label": drawing.label, "shapes": shapes}
