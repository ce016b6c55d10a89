"""The folder of a fit that nobody made: a body as it is, in any unit, with radii as they are given."""

import json
from pathlib import Path

from breastrig.core.arrays import Array
from breastrig.core.units import METRES_PER_UNIT
from breastrig.files.result import RESULT, UNCERTAINTY, ResultFile
from breastrig.geometry.rotations import quaternion_from_rotation
from breastrig.report.files.geometry_files import surface_ply
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from helpers.results import result_document


def write_fit(
    folder: Path, rig: Rig, vertices: Array, radii: Array, unit: str = "mm", stance: str = "standing", **result: object
) -> Path:
    """`vertices` (V, 3) m are scan and model, `radii` (V,) m; a line of the drawing runs over the first points."""
    folder.mkdir(parents=True)
    per_unit, x = METRES_PER_UNIT[unit], rest_parameters(rig)
    points = rig.landmark_points()
    places = dict(zip(rig.landmark_names, points.positions(vertices, rig.faces) / per_unit, strict=True))
    within = dict(zip(rig.landmark_names, points.positions(radii[:, None], rig.faces)[:, 0], strict=True))
    line = [point.tolist() for point in vertices[rig.regions["chest"][:5]] / per_unit]
    drawing = {"schema": "breastrig/drawing@1", "name": "own", "unit": unit, "notice": ""}
    drawing["shapes"] = [{"name": "cut", "closed": False, "color": "#101010", "points": line, "bridged": [False] * 5}]
    named = {name: place.tolist() for name, place in places.items()}
    turns = quaternion_from_rotation(x.rotations)
    bones = [
        {"name": name, "rotation_xyzw": list(turn), "translation_m": list(place), "scale": list(size)}
        for name, turn, place, size in zip(rig.bone_names, turns, x.translations, x.scales, strict=True)
    ]
    document = result_document(
        scan={"unit": unit, "vertices": len(vertices), "triangles": len(rig.faces)},
        model={"name": rig.name, "sha256": rig.sha256, "vertices": len(vertices)},
        stance=stance,
        refined=True,
        verdict={"level": "good", "reasons": []},
        landmarks=named,
        landmark_uncertainty_mm={name: 1e3 * radius for name, radius in within.items()},
        line_error_mm=5.0,
        parameters={"bones": bones, "blendshapes": dict(zip(rig.shape_names, x.weights.tolist(), strict=True))},
    )
    files = {
        "scan.ply": surface_ply(vertices, rig.faces, per_unit),
        "fitted.ply": surface_ply(vertices, rig.faces, per_unit),
        "drawing.json": json.dumps(drawing).encode(),
        UNCERTAINTY: (1e3 * radii).astype("<f4").tobytes(),
        RESULT: ResultFile.model_validate(document | result).content(),
    }
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder
