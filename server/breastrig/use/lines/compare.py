"""Two drawings on the scan of one fit: how far they are apart, as a table, a document and a picture."""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from breastrig.core.documents import csv_table, json_bytes
from breastrig.core.errors import BadDrawing
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.private_files import shown, write_files
from breastrig.drawings.drawing_file import Drawing, drawing_document, parsed_drawing
from breastrig.drawings.on_skin import check_on_skin
from breastrig.drawings.project_drawing import on_scan
from breastrig.drawings.superimposition.gaps import gaps
from breastrig.drawings.superimposition.picture import superimposed
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import ModelDrawing
from breastrig.rig.similarity import umeyama
from breastrig.use.folder.fit_folder import fit_folder_of
from breastrig.use.folder.whose import check_whose

SCHEMA = "breastrig/compare@1"
COMPARE_RECORD = "compare.json"
COMPARE_FILES = ("compare.csv", "compare.png", COMPARE_RECORD)


@dataclass(frozen=True)
class CompareJob:
    """Two drawings in the frame of one fit's scan; the first is shown black, the second white."""

    fit: Path
    first: Path
    second: Path
    out: Path
    model: Path | None = None  # None: the torso of the package
    same_patient: bool = False  # a person has said that both drawings are this patient's


def compare(job: CompareJob) -> dict[str, Any]:
    """Writes compare.json, compare.csv and compare.png into job.out; the first one's document.  Raises BadInput."""
    rig = read_rig(job.model or default_rig_path())
    folder = fit_folder_of(job.fit, rig)
    scan = folder.fitted_scan
    shapes = []
    for file in (job.first, job.second):
        document = drawing_document(file)
        check_whose(document, [folder.result], job.same_patient)
        given = parsed_drawing(document, rig, folder.unit)
        on_skin = list(given.on_scan)
        for shape in on_skin:
            try:
                check_on_skin(shape, scan.target.search.query(shape.points).distances)
            except BadDrawing as error:
                raise BadDrawing(f"{shown(file)}: {error}") from error
        on_skin += on_scan(rig, scan.vertices, _drawn(given), scan.target)
        shapes.append(on_skin)
    found = gaps(*shapes)
    picture = superimposed(
        scan.target.vertices,
        scan.target.faces,
        umeyama(rig.template, scan.vertices).rotation,
        (shapes[0], shapes[1]),
        (job.first.name, job.second.name),
        found,
    )
    rows = [
        {"shape": gap.name}
        | {
            key: round(value, 3)
            for key, value in (("mean_mm", gap.mean_mm), ("p95_mm", gap.p95_mm), ("max_mm", gap.max_mm))
        }
        for gap in found
    ]
    document = {
        "schema": SCHEMA,
        "notice": LIMITS_OF_USE,
        "first": job.first.name,
        "second": job.second.name,
        "only_in_one": sorted({each.name for each in shapes[0]} ^ {each.name for each in shapes[1]}),
        "distances": rows,
    }
    image = io.BytesIO()
    Image.fromarray(np.asarray(picture)).save(image, "PNG", optimize=True)
    contents = csv_table(list(rows[0]), rows), image.getvalue(), json_bytes(document)
    write_files(dict(zip(COMPARE_FILES, contents, strict=True)), job.out)
    return document


def _drawn(given: Drawing) -> ModelDrawing:
    return ModelDrawing(given.name, given.name, given.on_model)
