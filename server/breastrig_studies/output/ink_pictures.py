"""Pictures of the scans whose ink is found worst, with true and found lines."""

import io
from collections.abc import Sequence

import numpy as np
from PIL import Image
from scipy.spatial import cKDTree

from breastrig.colour.ink.find_ink import find_ink
from breastrig.core.arrays import Array
from breastrig.geometry.polyline import resampled
from breastrig.rendering.picture import Layer, Line, camera
from breastrig.rendering.picture import Scene as Meshes
from breastrig.scan.read import read_scan
from breastrig_studies.output.pictures import PAPER, SCAN_GREY
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.ink import REACH, true_lines
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import of
from breastrig_studies.tables.ink import chosen_factor

SIZE = (380, 460)  # pixels a picture
WORST = 2  # scans that are shown
VIEWS = ("front", "left", "right")
FOUND, MISSED, WRONG = (0.12, 0.29, 0.65), (0.93, 0.55, 0.05), (0.8, 0.05, 0.1)
DOTS = 1e-3  # m between the dots that lines are drawn of


def ink_pictures(records: Sequence[Record]) -> dict[str, bytes]:
    """Name -> PNG of the worst scans, the worst first."""
    result = {}
    for record in _worst(records):
        scene = read_scene(record.case)
        scan = read_scan(record.case.scan, None, record.case.unit)
        lines = true_lines(record.case, None)
        found = [resampled(each.line.points, DOTS, each.line.closed) for each in find_ink(scan)]
        places = np.concatenate([np.zeros((0, 3)), *found])
        wanted = lines.places[lines.wanted]
        wrong = cKDTree(lines.places).query(places)[0] > REACH
        missed = cKDTree(places).query(wanted)[0] > REACH if len(places) else np.ones(len(wanted), dtype=np.bool_)
        dots = [
            Line(place[None], colour, 3.0)
            for group, colour in ((places[~wrong], FOUND), (wanted[missed][::2], MISSED), (places[wrong], WRONG))
            for place in group
        ]
        mesh = Meshes([Layer(scene.target.vertices, scene.target.faces, SCAN_GREY)])
        sheet = Image.new("RGB", (len(VIEWS) * SIZE[0], SIZE[1]))
        axes = _axes(scene)
        for column, view in enumerate(VIEWS):
            framed = camera(view, scene.target.vertices, frame=axes, aspect=SIZE[0] / SIZE[1], margin=0.05)
            sheet.paste(Image.fromarray(mesh.render(framed, SIZE, dots, PAPER)), (column * SIZE[0], 0))
        stream = io.BytesIO()
        sheet.save(stream, "PNG", optimize=True)
        result[_name(record)] = stream.getvalue()
    return result


def _name(record: Record) -> str:
    return f"ink_{record.case.patient}_{record.case.name}"


def _axes(scene: Scene) -> Array:
    """(3, 3) columns: the patient's left, up and front in the scan's frame, from the true landmarks."""
    places = scene.landmarks
    left = places["nipple_L"] - places["nipple_R"]
    front = np.cross(left, places["suprasternal_notch"] - places["umbilicus"])
    axes = np.stack([left, np.cross(front, left), front], axis=1)
    return np.asarray(axes / np.linalg.norm(axes, axis=0))


def _worst(records: Sequence[Record]) -> list[Record]:
    found = [record for record in of(records, "ink") if not record.failed and record.answer["1"]["true_mm"] > 0.0]

    def quality(record: Record) -> float:
        numbers = record.answer[f"{chosen_factor([each for each in found if each is not record]):g}"]
        return min(numbers["recall"] or 0.0, numbers["precision"] or 0.0)

    return sorted(found, key=quality)[:WORST]
