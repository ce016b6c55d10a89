"""The cut scans on the page: the answer in words, and pictures of the median fit of each family."""

import io
from collections.abc import Sequence

from PIL import Image

from breastrig.rendering.picture import Layer, camera, render
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig_studies.page.pictures import PAPER, SCAN_GREY, chosen
from breastrig_studies.page.section import Section, capital, mm
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.unseen import CUTS, cut_fit, whole_fit
from breastrig_studies.tables.accuracy import FAMILIES, of
from breastrig_studies.tables.table import mean
from breastrig_studies.tables.unseen import WORDS

SIZE = (250, 300)  # pixels a picture


def unseen_section(records: Sequence[Record]) -> Section:
    answers = []
    for family in FAMILIES:
        for cut, words in WORDS.items():
            parts = [
                record.answer[cut]
                for record in of(records, "unseen")
                if record.case.family == family and cut in record.answer
            ]
            if not parts:
                continue
            scales = min(p["smallest_scale"] for p in parts), max(p["largest_scale"] for p in parts)
            volumes = min(p["volume"] for p in parts), max(p["volume"] for p in parts)
            answers.append(
                f"{capital(family)}, {words}: bones keep {scales[0]:.2f} to {scales[1]:.2f} of the whole scan's scales "
                f"and the body {volumes[0]:.2f} to {volumes[1]:.2f} of its volume; the skin lies "
                f"{mm(mean(p['moved_mm'] for p in parts), 1)} from the whole scan's fit on average."
            )
    return Section(
        "unseen",
        "Does what the scan does not show stay human?",
        "Each scan cut at the navel, at the nipples and along the midline, fitted with the landmarks that are left. "
        "Pictures: what is left of the scan, its fit, and below the fit of the whole scan.",
        tuple(answers),
        ("unseen_independent", "unseen_makehuman"),
        ("unseen",),
    )


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
                    picture = render([layer], framed, SIZE, background=PAPER)
                    sheet.paste(Image.fromarray(picture), (x * SIZE[0], y * SIZE[1]))
            stream = io.BytesIO()
            sheet.save(stream, "PNG", optimize=True)
            result[f"unseen_{family}"] = stream.getvalue()
    return result
