"""The worker's side of one upload: read it, say what it is, write what is kept and the mesh for display.  Also that of
lesions of another file than their image's, of which only numbers are kept.

An upload is hostile until it has been read, and holds more of a patient than the skin.  This runs in a process of its
own with limits of memory and time, gives back nothing but numbers and sentences, and writes a file of our own, from
which everything later starts; the upload itself is not kept.  How the patient lies in the scan is among the numbers:
proposals and fits of this scan begin with it.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.stances import AUTO
from breastrig.fitting.hypotheses import scan_orientation
from breastrig.fitting.prepare_scan import prepared_scan
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.scan_mesh import scan_mesh
from breastrig.report.pictures import thumbnail_png
from breastrig.scan.clean import Surface
from breastrig.scan.images.added_lesions import LesionsRead
from breastrig.scan.images.read_lesions import lesions_in
from breastrig.scan.kept_image import KeptImage, read_image, write_image
from breastrig.scan.piece import TakenSegment
from breastrig.scan.read import read_scan
from breastrig.scan.stored_scan import write_stored
from breastrig.scan.units import extent, size_doubt
from breastrig.scan.unscaled import UNKNOWN_SIZE
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers


@dataclass(frozen=True)
class UploadJob:
    """An upload to be read."""

    scan: Path  # the uploaded bytes; the suffix gives the type
    units: str
    kept: Path  # where the scan itself is written, as a STORED file
    mesh: Path  # where the mesh for display is written
    thumbnail: Path  # where a small picture is written
    volume: Path  # where the image is written, of a scan that was made of one
    triangles: int  # at most
    model: Path | None = None  # that the service fits with; None: the torso of the package
    answers: VolumeAnswers = NOTHING_SAID  # of a label map


@dataclass(frozen=True)
class LesionsJob:
    """Lesions of another file, to be read."""

    file: Path  # the uploaded bytes
    volume: Path  # the image of the scan that they lie in
    answers: VolumeAnswers = NOTHING_SAID


PIECES = 20  # the largest, at most so many, are reported to the page


def read_upload(job: UploadJob) -> dict[str, Any]:
    """The facts of the scan, ready for JSON.  Raises BadScan or TooLarge with a sentence."""
    with _sentences():
        return _read(job)


def read_lesions(job: LesionsJob) -> LesionsRead:
    """The lesions, mm, in the frame of the image.  Raises BadScan or TooLarge with a sentence, OSError."""
    with _sentences():
        return lesions_in(job.file, read_image(job.volume), job.answers)


@contextmanager
def _sentences() -> Iterator[None]:
    try:
        yield
    except MemoryError as error:
        raise BadScan("Reading this scan needs more memory than it may use; give a smaller file.") from error
    except RecursionError as error:
        raise BadScan("This scan's file is nested too deeply to be read.") from error


def _read(job: UploadJob) -> dict[str, Any]:
    scan = read_scan(job.scan, job.scan.suffix.lstrip("."), job.units, answers=job.answers)
    if len(scan.faces) > job.triangles:
        raise TooLarge(
            f"This scan has {len(scan.faces):,} triangles, more than the {job.triangles:,} allowed; simplify it first."
        )
    rig = read_rig(job.model or default_rig_path())
    ready = prepared_scan(scan, AUTO)
    orientation, _, _ = scan_orientation(rig, ready, load_recipe("default"))
    body = ready.target.vertices[np.unique(ready.target.faces)]
    table = ready.target.table
    mesh, body_triangles = scan_mesh(scan, Surface(ready.target.vertices, ready.target.faces, ()))
    job.mesh.write_bytes(mesh)
    is_whole = ready.target.faces is ready.surface.faces  # no table was cut away
    rays = ready.target.rays if is_whole else None
    job.thumbnail.write_bytes(thumbnail_png(ready.surface, orientation.body_frame(), rays))
    write_stored(scan, job.kept)
    if scan.image is not None:
        write_image(scan.image, job.volume)
    return {
        "unit": scan.unit,
        "unit_reason": scan.unit_reason,
        "size_doubt": size_doubt(
            extent(ready.target.vertices[ready.target.faces[:, 0]]), scan.unit, scan.in_patient_frame
        ),
        "size_known": scan.size_known,
        "vertices": len(scan.vertices),
        "triangles": len(scan.faces),
        "body_triangles": body_triangles,
        "bounds_m": {"min": scan.vertices.min(axis=0).tolist(), "max": scan.vertices.max(axis=0).tolist()},
        "size_m": np.ptp(body @ orientation.start.rotation, axis=0).tolist(),
        "colours": scan.colour_kind,
        "reconstructed_from_points": scan.from_points,
        "notes": [*scan.notes, *ready.surface.notes, *(() if scan.size_known else (UNKNOWN_SIZE,))],
        "lesions": [
            {"name": each.name, "center": (1e3 * each.center).tolist(), "radius_mm": 1e3 * each.radius}
            for each in scan.lesions
        ],
        "segments": [segment_facts(each) for each in scan.segments],
        "labels": [each.label for each in scan.segments],  # for the first answer alone; never kept
        "cut_away_cm2": round(1e4 * ready.cut_away),
        "background": [{"normal": normal.tolist(), "height_m": height} for normal, height in ready.frame.background],
        "table": None if table is None else {"normal": table.normal.tolist(), "height_m": table.height},
        "other_pieces": [piece.place.tolist() for piece in ready.beside[:PIECES]],
        "frame": orientation.body_frame(),
        "stance": {"proposed": orientation.stance, "reason": orientation.stance_reason},
        "orientation": orientation.facts(),
        "image": None if scan.image is None else _image_facts(scan.image),
    }


def segment_facts(segment: TakenSegment) -> dict[str, Any]:
    """What may be kept of it: none of the file's words."""
    return {name: fact for name, fact in asdict(segment).items() if name != "label"}


def _image_facts(image: KeptImage) -> dict[str, Any]:
    """Its size and place: `to_scan` leads from indices of a voxel's middle to mm of the scan's frame."""
    return {"shape": list(image.values.shape), "to_scan": image.affine.tolist(), "bytes": image.values.nbytes}
