"""Pictures of the cut scans: the median fit of each family."""

import io
from collections.abc import Sequence

from PIL import Image

from breastrig.rendering.picture import Layer, Scene, camera
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig_studies.output.pictures import PAPER, SCAN_GREY, chosen
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.unseen import CUTS, cut_fit, whole_fit
from breastrig_studies.tables.accuracy import FAMILIES

SIZE = (250, 300)  # pixels a picture


def unseen_pictures(records: Sequence[Record], rig: Rig, preset: str) -> dict[str, bytes]:
    """Name -> PNG for the median fit of each family: each cut's scan and fit in two views, the whole one below."""
    result = {}
    for family in FAMILIES:
        median = [record for place, record in chosen(records, preset, family) if place == "median"]
        for record in median[:1]:
            scene = read_scene(record.case)
            whole = whole_fit(scene, rig, record.unit.recipe)
            axes = umeyama(rig.template, whole.vertices).rotation
            cuts = [cut_fit(scene, rig, record.unit.recipe, whole, cut) for cut in CUTS]
            fits = [(part.scene.target, part.fit.vertices) for part in cuts if part is not None]
            fits.append((scene.target, whole.vertices))
            sheet = Image.new("RGB", (4 * SIZE[0], len(fits) * SIZE[1]))
            for y, (target, vertices) in enumerate(fits):
                layers = Layer(target.vertices, target.faces, SCAN_GREY), Layer(vertices, rig.faces)
                for x, (layer, view) in enumerate((layer, view) for view in ("front", "left") for layer in layers):
                    framed = camera(view, whole.vertices, frame=axes, aspect=SIZE[0] / SIZE[1], margin=0.05)
                    picture = Scene([layer]).render(framed, SIZE, background=PAPER)
                    sheet.paste(Image.fromarray(picture), (x * SIZE[0], y * SIZE[1]))
            stream = io.BytesIO()
            sheet.save(stream, "PNG", optimize=True)
            result[f"unseen_{family}"] = stream.getvalue()
    return result
