"""The evaluation as one self-contained page: no script, no other file, light and dark."""

import base64
import hashlib
import json
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

import numpy
import scipy
from jinja2 import Environment, StrictUndefined

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.rig.model import Rig
from breastrig_studies.evaluate import Results
from breastrig_studies.page.figures import HEADINGS, spaced
from breastrig_studies.page.pictures import FitPicture
from breastrig_studies.page.section import Section
from breastrig_studies.tables.accuracy import FAMILIES, of, value
from breastrig_studies.tables.table import Table


@dataclass(frozen=True)
class Circumstances:
    """What a reader needs to do it again."""

    command: str
    data: str
    jobs: int


@dataclass(frozen=True)
class Tile:
    """A headline number of one family."""

    number: str
    unit: str
    what: str


def as_uri(kind: str, data: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


def headline(results: Results) -> list[tuple[str, int, list[Tile]]]:
    """(family, scans, tiles): the few numbers to remember."""
    first = results.plan.recipes[0].name
    sources = (
        ("accuracy", "surface_mm.mean", "mm", "to the scanned skin"),
        ("accuracy", "truth_mm.mean", "mm", "to the true skin"),
        ("accuracy", "landmark_mm.mean", "mm", "landmarks given"),
        ("halves", "landmarks_mm", "mm", "the other half, half given"),
        ("no_landmarks", "landmarks_mm", "mm", "landmarks, none given"),
        ("accuracy", "time_s", "s", "to solve"),
    )
    result = []
    for family in FAMILIES:
        tiles, scans = [], 0
        for question, path, unit, what in sources:
            found = [r for r in of(results.records, question, first) if r.case.family == family and not r.failed]
            numbers = [number for r in found if (number := value(r.answer, path)) is not None]
            scans = max(scans, len(found))
            if numbers:
                tiles.append(Tile(f"{sum(numbers) / len(numbers):.2f}", unit, what))
        if tiles:
            result.append((HEADINGS[family], scans, tiles))
    return result


def facts(results: Results, rig: Rig, about: Circumstances) -> list[tuple[str, str]]:
    """The footer: command, data, model, presets and machine."""
    cases = results.plan.cases
    presets = []
    for recipe in results.plan.recipes:
        contents = json.dumps(recipe.model_dump(mode="json"), sort_keys=True)
        presets.append(f"{recipe.name} ({hashlib.sha256(contents.encode()).hexdigest()[:12]})")
    machine = f"{platform.machine()}, {platform.system()}, {os.cpu_count()} cores, {about.jobs} used"
    versions = f"BreastRig {__version__}, Python {platform.python_version()}, NumPy {numpy.__version__}"
    return [
        ("Command", about.command),
        ("Data", f"{about.data}: {len(cases)} scans of {len({case.patient for case in cases})} patients"),
        ("Model", f"{rig.name}, {len(rig.template)} vertices, {len(rig.shapes)} blendshapes, sha256 {rig.sha256[:16]}"),
        ("Presets", ", ".join(presets)),
        ("Machine", machine),
        ("Versions", f"{versions}, SciPy {scipy.__version__}"),
    ]


def page(
    results: Results,
    rig: Rig,
    about: Circumstances,
    sections: Sequence[Section],
    tables: dict[str, Table],
    figures: dict[str, tuple[bytes, bytes]],  # name -> light and dark PNG
    pictures: Sequence[FitPicture],
) -> str:
    """The HTML text."""
    source = (resources.files("breastrig_studies.page") / "page.html").read_text("utf-8")
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    return environment.from_string(source).render(
        headline=headline(results),
        sections=sections,
        tables=tables,
        figures={
            name: (as_uri("png", light), as_uri("png", dark), *_size(light)) for name, (light, dark) in figures.items()
        },
        pictures=[(picture, HEADINGS[picture.family], as_uri("jpeg", picture.jpeg)) for picture in pictures],
        virtual=any((case.folder / "truth.ply").is_file() for case in results.plan.cases),
        makehuman=any(case.family == "makehuman" for case in results.plan.cases),
        quick=results.plan.quick,
        facts=facts(results, rig, about),
        limits=LIMITS_OF_USE,
        spaced=spaced,
    )


def _size(png: bytes) -> tuple[int, int]:
    """Width and height in pixels, from the file's header."""
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")
