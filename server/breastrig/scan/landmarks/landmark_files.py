"""Landmark files, in and out: ours (JSON), tables, MeshLab's picked points (.pp), 3D Slicer's (.mrk.json, .fcsv).

Points are in the scan's frame; ours may name its unit, the others are in the scan's unit, whatever Slicer's "mm" says.
Slicer turns mesh and markup files alike from LPS into RAS and back: points stored as LPS, its default, have the mesh
file's numbers, points stored as RAS have x and y of the other sign.
"""

import csv
import json
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.documents import csv_table
from breastrig.core.errors import BadLandmarks
from breastrig.core.picks import Picks
from breastrig.core.private_files import read_ordinary, shown
from breastrig.core.units import BEYOND, METRES_PER_UNIT
from breastrig.scan.landmarks.tables import (
    Pairs,
    fcsv_landmarks,
    is_fcsv,
    landmark_editor,
    lddmm_landmarks,
    number,
    table_landmarks,
)

SCHEMA = "breastrig/landmarks@1"
SLICER_SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
    "markups-schema-v1.0.3.json#"
)
SLICER_TO_MESH = {"LPS": np.array([1.0, 1.0, 1.0]), "RAS": np.array([-1.0, -1.0, 1.0])}
FILE_TYPES = ("json", "csv", "pp", "mrk.json")
FORMATS = (
    "a landmark file is JSON, CSV (name,x,y,z), MeshLab .pp, 3D Slicer .mrk.json or .fcsv, or Landmark Editor .pts"
)
NAME_KEYS = ("name", "label", "id")
POINT_KEYS = ("position", "point", "coordinates")
CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")
REACH = 0.25  # m; a landmark may lie in a hole or beside the seen part, but not further out than this
APART = 0.1  # m between the farthest landmarks on a body, or to one from the origin, where a wrong unit puts all
LIMIT_BYTES = 10_000_000
LIMIT_POINTS = 1000
LIMIT_NAME = 100  # characters


def read_landmarks(source: Path | bytes, file_type: str | None = None) -> tuple[dict[str, Array], str | None]:
    """({name: (3,) point in the scan's frame}, unit of the file or None for the scan's unit).

    The kind of file is decided from its content; `file_type` (the name's ending) only words the error.  Names
    are not compared with any model here.  Raises BadLandmarks with one sentence.
    """
    text = _text(source)
    start = text.lstrip()[:1]
    if start in ("{", "["):
        pairs, unit = _from_json(text)
    elif start == "<":
        pairs, unit = _from_meshlab(text), None
    else:
        pairs, unit = _from_table(text, file_type or (source.suffix if isinstance(source, Path) else ""))
    if not pairs and not _parsed(text).get("marks"):
        raise BadLandmarks("This landmark file holds no landmarks; pick some and export them again.")
    return _checked(pairs), unit


def read_marks(source: Path | bytes) -> tuple[dict[str, Array], bool]:
    """({name: (3,) point in the file's unit} of "marks", whether names that no landmark has are marks too).

    They are in files that have no place for marks: tables, and those of MeshLab and 3D Slicer.  Raises BadLandmarks.
    """
    document = _parsed(_text(source))
    listed = document.get("marks", _Pairs([]))
    if not isinstance(listed, _Pairs):
        raise BadLandmarks('"marks" in this landmark file must be places by name, as in {"mole": [1.0, 2.0, 3.0]}.')
    return _checked([(name, _point(given)) for name, given in listed.pairs], "mark"), not document or (
        "markups" in document
    )


def landmark_confidences(source: Path | bytes) -> dict[str, float]:
    """Name -> confidence (0 to 1) of a file that `breastrig landmarks` proposed; empty for picks of a person.

    Raises BadLandmarks with one sentence.
    """
    text = _text(source)
    if text.lstrip()[:1] != "{":
        return {}
    _from_json(text)
    found = json.loads(text).get("confidence", {})
    if not isinstance(found, dict):
        raise BadLandmarks('"confidence" in this landmark file must name landmarks; remove it or propose them again.')
    for name, value in found.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= 1.0:
            raise BadLandmarks(f"The confidence of {name[:LIMIT_NAME]} in this landmark file must be from 0 to 1.")
    return {name: float(value) for name, value in found.items()}


def landmark_scale(source: Path | bytes) -> float | None:
    """The scan's size in which the places of our JSON are, times that of its file; None where that is not said.

    Raises BadLandmarks.
    """
    document = _parsed(_text(source))
    scale = document.get("scale") if document.get("schema") == SCHEMA else None
    if scale is not None and (isinstance(scale, bool) or not isinstance(scale, float | int) or not 0.0 < scale < 1e3):
        raise BadLandmarks('"scale" in this landmark file is no number above 0; mend or remove it.')
    return scale


def certain_landmarks(source: Path | bytes) -> tuple[str, ...]:
    """The picks that a person is certain of, as the file names them; none in files of other programs.

    Raises BadLandmarks with one sentence.
    """
    text = _text(source)
    if text.lstrip()[:1] != "{":
        return ()
    pairs, _ = _from_json(text)
    found = json.loads(text).get("certain", [])
    if not isinstance(found, list) or not all(isinstance(name, str) for name in found):
        raise BadLandmarks('"certain" in this landmark file must be a list of landmarks\' names; mend or remove it.')
    return checked_certain(found, _checked(pairs), landmark_confidences(source))


def checked_certain(
    certain: Sequence[str], landmarks: Collection[str], confidences: Mapping[str, float]
) -> tuple[str, ...]:
    """The names, each once, in the order given.

    Raises BadLandmarks for a name without a pick, and for one that is only proposed (a confidence below 1).
    """
    for name in certain:
        shown_name = name[:LIMIT_NAME]
        if name not in landmarks:
            raise BadLandmarks(
                f'"certain" names {shown_name}, which is not among these landmarks; pick it or take it out.'
            )
        if confidences.get(name, 1.0) < 1.0:
            raise BadLandmarks(
                f"{shown_name} is proposed and cannot be certain; place it by hand, or remove its confidence."
            )
    return tuple(dict.fromkeys(certain))


def landmark_file(
    places: Mapping[str, Array],
    file_type: str = "json",
    unit: str | None = None,
    certain: Sequence[str] = (),
    confidence: Mapping[str, float] = MappingProxyType({}),
    marks: Mapping[str, Array] = MappingProxyType({}),
    scale: float = 1.0,
) -> bytes:
    """The bytes of a landmark file; file_type is one of FILE_TYPES.

    `unit`, `certain`, `confidence` and `scale` (landmark_scale) are written into our JSON only: in the other kinds the
    points must be in the scan's unit, and there is no place for what is known of them; marks are points among the
    others there.
    """
    points, marked = ({name: list(map(float, place)) for name, place in each.items()} for each in (places, marks))
    if file_type == "json":
        document: dict[str, Any] = {"schema": SCHEMA} | ({"unit": unit} if unit else {}) | {"landmarks": points}
        document |= {"certain": list(certain)} if certain else {}
        document |= {"confidence": dict(confidence)} if confidence else {}
        document |= {"marks": marked} if marked else {}
        document |= {"scale": scale} if scale != 1.0 else {}
        return (json.dumps(document, indent=1, allow_nan=False) + "\n").encode()
    points |= marked
    if file_type == "csv":
        rows = ({"name": name, **dict(zip("xyz", point, strict=True))} for name, point in points.items())
        return csv_table(("name", "x", "y", "z"), rows)
    if file_type == "pp":
        return _meshlab(points)
    if file_type == "mrk.json":
        return _slicer(points)
    raise BadLandmarks(f'"{file_type}" is not a kind of landmark file; known are: {", ".join(FILE_TYPES)}.')


def _text(source: Path | bytes) -> str:
    try:
        data = source if isinstance(source, bytes) else read_ordinary(source, LIMIT_BYTES)
        if len(data) > LIMIT_BYTES:
            raise BadLandmarks(f"This landmark file is larger than {LIMIT_BYTES // 10**6} MB; {FORMATS}.")
        return _decoded(data)
    except OSError as error:
        raise BadLandmarks(
            f"The landmark file {shown(str(source))} cannot be read ({error.strerror}); check the name."
        ) from error
    except UnicodeDecodeError as error:
        raise BadLandmarks(f"This landmark file is not text; {FORMATS}.") from error


def _parsed(text: str) -> "_Pairs":
    """The JSON document; empty for a file of another kind."""
    if text.lstrip()[:1] not in ("{", "["):
        return _Pairs([])
    try:
        document = json.loads(text, object_pairs_hook=_Pairs)
    except (ValueError, RecursionError) as error:
        raise BadLandmarks("This landmark file is not valid JSON; export it again.") from error
    return document if isinstance(document, _Pairs) else _Pairs([("landmarks", document)])


def _from_json(text: str) -> tuple[list[tuple[str, Any]], str | None]:
    document = _parsed(text)
    if "markups" in document:
        return _from_slicer(document), None
    pairs = _plain_json(document) if document.get("schema", SCHEMA) == SCHEMA else None
    if pairs is None:
        raise BadLandmarks(f'This JSON is not a landmark file ("schema": "{SCHEMA}"); {FORMATS}.')
    unit = document.get("unit")
    if unit is not None and (not isinstance(unit, str) or unit not in METRES_PER_UNIT):
        raise BadLandmarks(f"The unit of this landmark file is not known; use {', '.join(METRES_PER_UNIT)}.")
    return pairs, unit


def _plain_json(document: "_Pairs") -> list[tuple[str, Any]] | None:
    """The points that "landmarks" holds, else the document: by name, or a list with names; None where it holds none."""
    is_ours = bool({"schema", "landmarks"} & document.keys())
    bare = _Pairs([pair for pair in document.pairs if pair[0] not in ("marks", "unit")])
    listed = document.get("landmarks", (_Pairs([]) if "marks" in document else None) if is_ours else bare)
    if isinstance(listed, list) and all(isinstance(each, dict) for each in listed):
        entries = [(next((each[key] for key in NAME_KEYS if key in each), ""), each) for each in listed]
    elif isinstance(listed, _Pairs):
        entries = listed.pairs
    else:
        return None
    pairs = [(name, _point(given)) for name, given in entries]
    return pairs if is_ours or all(isinstance(point, list) for _, point in pairs) else None


def _point(given: Any) -> Any:
    """The three numbers of {"x", "y", "z"} or of {"position"}; anything else as it is."""
    if not isinstance(given, dict):
        return given
    if all(axis in given for axis in "xyz"):
        return [given[axis] for axis in "xyz"]
    return next((given[key] for key in POINT_KEYS if key in given), given)


class _Pairs(dict[str, Any]):
    """A JSON object that remembers names that came twice."""

    def __init__(self, pairs: list[tuple[str, Any]]) -> None:
        super().__init__(pairs)
        self.pairs = pairs


def _from_slicer(document: Mapping[str, Any]) -> list[tuple[str, Any]]:
    pairs: list[tuple[str, Any]] = []
    try:
        for markup in document["markups"]:
            signs = _slicer_signs(str(markup.get("coordinateSystem", "LPS")))
            for point in markup["controlPoints"]:
                if point.get("positionStatus", "defined") != "defined":
                    continue  # a template's point that was not placed, or was skipped
                pairs.append((point["label"], [a * b for a, b in zip(point["position"], signs, strict=True)]))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BadLandmarks("This 3D Slicer markups file is incomplete; save the point list again.") from error
    return pairs


def _from_meshlab(text: str) -> list[tuple[str, Any]]:
    if "<!ENTITY" in text.upper():
        raise BadLandmarks("This .pp file defines entities, which picked points never need; export it again.")
    import xml.etree.ElementTree as ElementTree  # few landmark files are XML

    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        raise BadLandmarks(f"This file is not valid XML; {FORMATS}.") from error
    if root.tag != "PickedPoints":
        raise BadLandmarks(f"This XML is not a MeshLab .pp file; {FORMATS}.")
    return [
        (point.get("name", ""), [point.get(axis, "") for axis in "xyz"])
        for point in root.iter("point")
        if point.get("active", "1") != "0"  # a template's point that was not picked
    ]


def _from_table(text: str, file_type: str) -> tuple[Pairs, str | None]:
    try:
        if is_fcsv(text):
            system, pairs = fcsv_landmarks(text)
            signs = _slicer_signs(system)
            return [
                (name, [sign * number(cell) for sign, cell in zip(signs, cells, strict=True)]) for name, cells in pairs
            ], None
        pairs_only = landmark_editor(text) or lddmm_landmarks(text)
        found = (pairs_only, None) if pairs_only is not None else table_landmarks(text)
    except csv.Error as error:
        raise BadLandmarks(f"This CSV cannot be read; {FORMATS}.") from error
    except ValueError as error:
        raise BadLandmarks("A landmark in this file needs three numbers x, y, z; save the point list again.") from error
    if found is None:
        if not text.strip():
            raise BadLandmarks("This landmark file is empty; pick landmarks and export them again.")
        named = f"This file is named {file_type} but" if file_type else "This file"
        raise BadLandmarks(f"{named} holds no landmarks; {FORMATS}.")
    return found


def _slicer_signs(system: str) -> Array:
    """(3,) of a coordinate system as Slicer names it, now or in older versions."""
    signs = SLICER_TO_MESH.get({"0": "RAS", "1": "LPS"}.get(system, system).upper())
    if signs is None:
        raise BadLandmarks(f'The coordinate system "{system[:20]}" of this markups file is neither LPS nor RAS.')
    return signs


def _decoded(data: bytes) -> str:
    """Text in UTF-8 or UTF-16, or in the character set of older spreadsheets.  UnicodeDecodeError for what is none."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16")
    if b"\0" in data[:200]:
        return data.decode("utf-16-be" if data[:1] == b"\0" else "utf-16-le")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        if CONTROL.search(data):
            raise
        return data.decode("cp1252", "replace")


def metres_per_unit(
    places: Mapping[str, Array], unit: str | None, scan_unit: float, bounds: tuple[Array, Array]
) -> float:
    """Metres per unit of a file's places; without a named unit the scan's, or m, cm or mm where only that lies on it.

    `scan_unit` in m, `bounds` the (3,) lowest and highest place of the scan in m.
    """
    if unit is not None:
        return METRES_PER_UNIT[unit]
    points, (low, high) = np.array(list(places.values())), bounds

    def lie_on_scan(metres: float) -> bool:
        return bool(((metres * points > low - REACH) & (metres * points < high + REACH)).all())

    if lie_on_scan(scan_unit) or not len(points):
        return scan_unit
    spread = float(np.abs(points if len(points) == 1 else np.ptp(points, axis=0)).max())
    others = (METRES_PER_UNIT[other] for other in ("m", "cm", "mm"))
    return next((metres for metres in others if lie_on_scan(metres) and metres * spread > APART), scan_unit)


def landmarks_of_file(
    source: Path | bytes,
    scan: Callable[[], tuple[float, tuple[Array, Array]]],
    file_type: str | None = None,
    scale: float = 1.0,
) -> Picks:
    """The landmarks of a file, mm; `scan` gives unit (m) and bounds as above, called only where the file has no unit.

    `scale` is the scan's size, times that of its file: places that are said to be of another are taken to it.
    Raises BadLandmarks with one sentence.
    """
    places, unit = read_landmarks(source, file_type)
    marks, open_names = read_marks(source)
    metres = METRES_PER_UNIT[unit] if unit else metres_per_unit({**marks, **places}, None, *scan())
    points, marked = (
        {name: (1e3 * metres * place).tolist() for name, place in each.items()} for each in (places, marks)
    )
    picks = Picks(points, certain_landmarks(source), landmark_confidences(source), marked, open_names)
    return picks.times(scale / (landmark_scale(source) or scale))


def _checked(pairs: list[tuple[str, Any]], kind: str = "landmark") -> dict[str, Array]:
    if len(pairs) > LIMIT_POINTS:
        raise BadLandmarks(f"This file holds {len(pairs):,} points, more than the {LIMIT_POINTS:,} allowed.")
    places: dict[str, Array] = {}
    for name, place in pairs:
        if not isinstance(name, str) or not name.strip() or len(name) > LIMIT_NAME:
            raise BadLandmarks(f"A {kind} in this file has no proper name; give each point its {kind}'s name.")
        name = name.strip()
        if name in places:
            raise BadLandmarks(f'The {kind} "{name}" stands twice in this file; keep one.')
        places[name] = np.array(_three_numbers(name, place, kind))
    return places


def _three_numbers(name: str, place: Any, kind: str) -> list[float]:
    try:
        if isinstance(place, str | bytes) or len(place) != 3 or any(isinstance(value, bool) for value in place):
            raise TypeError
        numbers = [number(value) for value in place]
    except (TypeError, ValueError, OverflowError) as error:
        raise BadLandmarks(f'The {kind} "{name}" needs three numbers x, y, z.') from error
    if not all(math.isfinite(value) for value in numbers):
        raise BadLandmarks(f'The {kind} "{name}" has a coordinate that is not a finite number; pick it again.')
    if max(map(abs, numbers)) > BEYOND:
        raise BadLandmarks(f'The {kind} "{name}" has a coordinate larger than 1e9; check the file and its unit.')
    return numbers


def _meshlab(points: Mapping[str, list[float]]) -> bytes:
    import xml.etree.ElementTree as ElementTree

    root = ElementTree.Element("PickedPoints")
    for name, point in points.items():
        axes = {axis: repr(value) for axis, value in zip("xyz", point, strict=True)}
        ElementTree.SubElement(root, "point", {**axes, "active": "1", "name": name})
    ElementTree.indent(root, " ")
    return b"<!DOCTYPE PickedPoints>\n" + ElementTree.tostring(root) + b"\n"


def _slicer(points: Mapping[str, list[float]]) -> bytes:
    document = {
        "@schema": SLICER_SCHEMA,
        "markups": [
            {
                "type": "Fiducial",
                "coordinateSystem": "LPS",
                "coordinateUnits": "mm",
                "controlPoints": [
                    {"id": str(index + 1), "label": name, "position": point, "positionStatus": "defined"}
                    for index, (name, point) in enumerate(points.items())
                ],
            }
        ],
    }
    return (json.dumps(document, indent=1, allow_nan=False) + "\n").encode()
