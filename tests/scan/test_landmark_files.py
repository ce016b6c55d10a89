"""Landmark files of four kinds, in and out, and one sentence for each that cannot be used."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from breastrig.core.errors import BadLandmarks
from breastrig.scan.landmarks.landmark_files import (
    FILE_TYPES,
    certain_landmarks,
    landmark_confidences,
    landmark_file,
    landmarks_of_file,
    metres_per_unit,
    read_landmarks,
)
from breastrig.scan.landmarks.names import by_known_names, known_name

PLACES = {
    "nipple_L": np.array([102.25, -11.0, 1e-3]),
    "nipple_R": np.array([-98.5, -12.125, 0.3]),
    "umbilicus": np.array([0.1, 0.2, 1234.5678901]),
}


def same(found: dict[str, np.ndarray], wanted: dict[str, np.ndarray] = PLACES) -> bool:
    return list(found) == list(wanted) and all(np.array_equal(found[name], wanted[name]) for name in wanted)


@pytest.mark.parametrize("kind", FILE_TYPES)
def test_each_kind_comes_back_exactly_as_it_was_written(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"picks.{kind}"
    path.write_bytes(landmark_file(PLACES, kind, "mm"))
    for source in (path, path.read_bytes()):
        places, unit = read_landmarks(source)
        assert same(places)
        assert unit == ("mm" if kind == "json" else None)


def test_the_unit_is_optional() -> None:
    assert read_landmarks(landmark_file(PLACES))[1] is None


def test_our_json_is_the_one_of_the_specification() -> None:
    document = json.loads(landmark_file({"xiphoid": np.array([1.0, 2.0, 3.0])}, "json", "mm"))
    assert document == {"schema": "breastrig/landmarks@1", "unit": "mm", "landmarks": {"xiphoid": [1.0, 2.0, 3.0]}}


@pytest.mark.parametrize(
    "text",
    [
        "name,x,y,z\nxiphoid,1.5,2,3\n",
        "xiphoid,1.5,2,3",
        "# picked by hand\n\nlabel, x, y, z\r\n xiphoid , 1.5 , 2 , 3 \r\n",
        "xiphoid;1,5;2;3\n",
        "Name\tX\tY\tZ\nxiphoid\t1.5\t2\t3\n",
        '\ufeffname,x,y,z\n"xiphoid",1.5,2,3\n',
    ],
)
def test_csv_as_people_and_spreadsheets_write_it(text: str) -> None:
    assert same(read_landmarks(text.encode())[0], {"xiphoid": np.array([1.5, 2.0, 3.0])})


def test_meshlab_points_that_were_not_picked_are_skipped() -> None:
    text = b"""<!DOCTYPE PickedPoints>
<PickedPoints>
 <DocumentData><DataFileName name="scan.ply"/></DocumentData>
 <point x="1.5" y="2" z="3" active="1" name="xiphoid"/>
 <point x="0" y="0" z="0" active="0" name="umbilicus"/>
</PickedPoints>"""
    assert same(read_landmarks(text)[0], {"xiphoid": np.array([1.5, 2.0, 3.0])})


def markups(system: str | None, status: str = "defined") -> bytes:
    markup = {
        "type": "Fiducial",
        "coordinateUnits": "mm",
        "controlPoints": [{"id": "1", "label": "xiphoid", "position": [1.5, 2.0, 3.0], "positionStatus": status}],
    }
    return json.dumps({"markups": [markup | ({"coordinateSystem": system} if system else {})]}).encode()


@pytest.mark.parametrize(
    ("system", "signs"),
    [("LPS", [1, 1, 1]), (None, [1, 1, 1]), ("RAS", [-1, -1, 1]), ("0", [-1, -1, 1]), ("1", [1, 1, 1])],
)
def test_slicers_points_are_turned_into_the_frame_of_the_mesh_file(system: str | None, signs: list[int]) -> None:
    places, unit = read_landmarks(markups(system))
    np.testing.assert_array_equal(places["xiphoid"], np.array([1.5, 2.0, 3.0]) * signs)
    assert unit is None


def test_a_slicer_template_without_placed_points_holds_no_landmarks() -> None:
    with pytest.raises(BadLandmarks, match="holds no landmarks"):
        read_landmarks(markups("LPS", "undefined"))


POINTS = {
    "nipple_L": [102.25, -11.5, 0.125],
    "nipple_R": [-98.5, -12.125, 3.0],
    "suprasternal_notch": [0.5, 210.25, 7.5],
}


def ours(**landmarks: object) -> bytes:
    return json.dumps({"schema": "breastrig/landmarks@1", "landmarks": landmarks}).encode()


@pytest.mark.parametrize(
    "document",
    [
        POINTS,
        {"landmarks": [{"name": name, "position": place} for name, place in POINTS.items()]},
        [dict(zip(("label", "x", "y", "z"), (name, *place), strict=True)) for name, place in POINTS.items()],
        {name: dict(zip("xyz", place, strict=True)) for name, place in POINTS.items()},
    ],
)
def test_json_without_a_schema_as_programs_write_it(document: object) -> None:
    assert_the_points(json.dumps(document).encode())


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "empty"),
        (b"\n\n", "empty"),
        (b"just some text", "holds no landmarks"),
        (b"\x89PNG\r\n\x1a\n\xff\xfe", "not text"),
        (b"{", "not valid JSON"),
        (b"[1, 2]", "not a landmark file"),
        (b'[{"x": 1, "y": 2, "z": 3}]', "no proper name"),
        (b'[{"name": "a", "x": 1, "y": 2}]', '"a" needs three numbers'),
        (b'{"a": [1, 2, 3], "b": {"place": 1}}', "not a landmark file"),
        (b"xiphoid,one,two,three", '"xiphoid" needs three numbers'),
        (b'{"a": 1}', "not a landmark file"),
        (b'{"schema": "breastrig/result@1", "landmarks": {"a": [1, 2, 3]}}', "not a landmark file"),
        (b'{"landmarks": {"a": [1, 2, 3]}, "unit": "yd"}', "unit"),
        (b'{"landmarks": {"a": [1, 2, 3]}, "unit": ["mm"]}', "unit"),
        (b'{"landmarks": {"a": [1, 2, 3], "a": [1, 2, 4]}}', '"a" stands twice'),
        (ours(), "holds no landmarks"),
        (ours(a=[1, 2]), '"a" needs three numbers'),
        (ours(a="123"), '"a" needs three numbers'),
        (ours(a=None), '"a" needs three numbers'),
        (ours(a=[1, 2, None]), '"a" needs three numbers'),
        (ours(a=[1, 2, True]), '"a" needs three numbers'),
        (ours(a=[1, 2, [3]]), '"a" needs three numbers'),
        (ours(a=[1, 2, 10**400]), '"a" needs three numbers'),
        (ours(a=[1, 2, float("nan")]), "not a finite number"),
        (ours(a=[1, 2, float("inf")]), "not a finite number"),
        (ours(a=[1, 2, 1e308]), "larger than 1e9"),
        (ours(a=[-(10**300), 2, 3]), "larger than 1e9"),
        (b"xiphoid,1,2," + b"9" * 300 + b"\n", "larger than 1e9"),
        (b'{"landmarks": {"": [1, 2, 3]}}', "no proper name"),
        (ours(**{"a" * 101: [1, 2, 3]}), "no proper name"),
        (b"name,x,y,z\nxiphoid,1,2\n", '"xiphoid" needs three numbers'),
        (b"name,x,y,z\nxiphoid,1,2,3,4\n", '"xiphoid" needs three numbers'),
        (b"name,x,y,z\nxiphoid,1,two,3\n", '"xiphoid" needs three numbers'),
        (b"name,x,y,z\nxiphoid,1,nan,3\n", "not a finite number"),
        (b"name,x,y,z\nxiphoid,1,2,3\nxiphoid,1,2,3\n", "stands twice"),
        (b"name,x,y,z\n", "holds no landmarks"),
        (b"<PickedPoints><point", "not valid XML"),
        (b"<html></html>", "not a MeshLab"),
        (b'<PickedPoints><point name="a" x="1" y="2"/></PickedPoints>', '"a" needs three numbers'),
        (b'<PickedPoints><point x="1" y="2" z="3"/></PickedPoints>', "no proper name"),
        (b'<!DOCTYPE P [<!ENTITY a "b">]><PickedPoints/>', "entities"),
        (markups("IJK"), "neither LPS nor RAS"),
        (b'{"markups": 3}', "incomplete"),
        (b'{"markups": [{"controlPoints": [{"label": "a"}]}]}', "incomplete"),
        (b'{"markups": [{"controlPoints": [{"label": "a", "position": [1, 2]}]}]}', "incomplete"),
        (b'{"markups": []}', "holds no landmarks"),
        (b"[" * 100_000, "not valid JSON"),
        (b'{"a":' * 100_000, "not valid JSON"),
    ],
)
def test_a_bad_file_is_refused_with_one_sentence(data: bytes, words: str) -> None:
    with pytest.raises(BadLandmarks) as caught:
        read_landmarks(data)
    text = str(caught.value)
    assert words in text
    assert "\n" not in text
    assert text.endswith(".")


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadLandmarks, match="cannot be read"):
        read_landmarks(tmp_path / "none.json")


def test_too_many_points_are_refused() -> None:
    with pytest.raises(BadLandmarks, match="more than the 1,000 allowed"):
        read_landmarks("\n".join(f"p{i},1,2,3" for i in range(1001)).encode())


def test_an_unknown_kind_cannot_be_written() -> None:
    with pytest.raises(BadLandmarks, match="known are: json, csv, pp"):
        landmark_file(PLACES, "docx")


def test_confidences_of_proposed_landmarks() -> None:
    text = b'{"landmarks": {"xiphoid": [1, 2, 3], "nipple_L": [4, 5, 6]}, "confidence": {"nipple_L": 0.25}}'
    assert landmark_confidences(text) == {"nipple_L": 0.25}
    assert landmark_confidences(b'{"landmarks": {"xiphoid": [1, 2, 3]}}') == {}
    assert landmark_confidences(b"name,x,y,z\nxiphoid,1,2,3\n") == {}


@pytest.mark.parametrize("value", ["2", "-0.1", "true", '"high"', "NaN"])
def test_a_confidence_that_is_none(value: str) -> None:
    text = f'{{"landmarks": {{"xiphoid": [1, 2, 3]}}, "confidence": {{"xiphoid": {value}}}}}'
    with pytest.raises(BadLandmarks, match="confidence of xiphoid in this landmark file must be from 0 to 1"):
        landmark_confidences(text.encode())


def test_certain_picks_come_back_as_they_were_written(tmp_path: Path) -> None:
    path = tmp_path / "picks.json"
    path.write_bytes(landmark_file(PLACES, unit="mm", certain=("umbilicus", "nipple_R")))
    for source in (path, path.read_bytes()):
        assert certain_landmarks(source) == ("umbilicus", "nipple_R")
        assert same(read_landmarks(source)[0])
    assert landmark_confidences(path) == {}


@pytest.mark.parametrize("kind", FILE_TYPES)
def test_nothing_is_certain_unless_the_file_says_so(kind: str) -> None:
    content = landmark_file(PLACES, kind, certain=() if kind == "json" else ("umbilicus",))
    assert b"certain" not in content
    assert certain_landmarks(content) == ()


@pytest.mark.parametrize(
    ("certain", "sentence"),
    [
        ('"xiphoid"', "must be a list of landmarks' names"),
        ('{"xiphoid": true}', "must be a list of landmarks' names"),
        ("[1]", "must be a list of landmarks' names"),
        ("null", "must be a list of landmarks' names"),
        ('["umbilicus"]', "names umbilicus, which is not among these landmarks; pick it or take it out."),
        ('["nipple_L"]', "nipple_L is proposed and cannot be certain"),
    ],
)
def test_what_cannot_be_certain_is_said_in_one_sentence(certain: str, sentence: str) -> None:
    text = '{"landmarks": {"xiphoid": [1, 2, 3], "nipple_L": [4, 5, 6]}, "confidence": {"nipple_L": 0.25}, '
    with pytest.raises(BadLandmarks, match=sentence) as refused:
        certain_landmarks(f'{text}"certain": {certain}}}'.encode())
    assert "\n" not in str(refused.value)


ROWS = [[name, *(f"{value:g}" for value in place)] for name, place in POINTS.items()]


def rows(separator: str = ",", order: str = "nxyz", head: str = "", decimal: str = ".", more: str = "") -> str:
    """The points as a table whose columns come in this order: name, number of the row, x, y, z, or a remark."""
    cells = []
    for k, (name, x, y, z) in enumerate(ROWS):
        found = {"n": name, "i": str(k + 1), "r": "seen well", "x": x, "y": y, "z": z, "o": "0"}
        cells.append(separator.join(found[each].replace(".", decimal) for each in order) + more)
    return "\n".join([*([head] if head else []), *cells, ""])


FCSV = """# Markups fiducial file version = 4.11
# CoordinateSystem = {system}
# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID
"""
FCSV_ROWS = {
    sign: "".join(
        f"vtkMRMLMarkupsFiducialNode_{k},{sign * float(x)},{sign * float(y)},{z},0,0,0,1,1,1,0,{name},,\n"
        for k, (name, x, y, z) in enumerate(ROWS)
    )
    for sign in (1, -1)
}
OLD_FCSV = "# Fiducial List\n# columns = label,x,y,z,sel,vis\n" + "".join(
    f"{name},{-float(x)},{-float(y)},{z},1,1\n" for name, x, y, z in ROWS
)
RENAMED = ["Nipple L", "RIGHT NIPPLE", "Suprasternal-Notch"]
TABLES = {
    "id first": rows(order="inxyz"),
    "id first with a head": rows(order="inxyz", head="id,name,x,y,z"),
    "xyz first": rows(order="xyzn"),
    "xyz first with a head": rows(order="xyzn", head="X,Y,Z,Label"),
    "xyz and id first": rows(order="ixyzn"),
    "id after the name": rows(order="nixyz"),
    "a remark behind": rows(order="nxyzr"),
    "more numbers behind": rows(order="nxyzoo", head="name,x,y,z,vis,sel"),
    "more numbers behind without a head": rows(order="nxyzoo"),
    "named pos": rows(head="label,pos x,pos y,pos z"),
    "named with units": rows(";", head="Landmark;X [mm];Y [mm];Z [mm]", decimal=","),
    "semicolons": rows(";"),
    "semicolons and decimal commas": rows(";", decimal=","),
    "tabs": rows("\t"),
    "tabs and decimal commas": rows("\t", decimal=","),
    "spaces": rows(" "),
    "spaces, head, decimal commas": rows("  ", head="name x y z", decimal=","),
    "commas and spaces": rows(", ", head="name, x, y, z"),
    "quoted decimal commas": "\n".join(",".join(f'"{cell.replace(".", ",")}"' for cell in row) for row in ROWS),
    "quotes": "\n".join(",".join(f'"{cell}"' for cell in row) for row in ROWS),
    "Excel's word of its separator": "sep=;\n" + rows(";"),
    "German words": rows(";", head="Punkt;X-Koordinate;Y-Koordinate;Z-Koordinate", decimal=","),
    "remarks of other programs": "// picked\n% today\n" + rows(),
    "Slicer's table, LPS": rows(order="nxyzo", head="label,l,p,s,locked"),
    "Slicer's table, RAS": "label,r,a,s,defined\n"
    + "".join(f"{name},{-float(x)},{-float(y)},{z},1\n" for name, x, y, z in ROWS)
    + "xiphoid,0,0,0,0\n",
    "fcsv in LPS": FCSV.format(system="LPS") + FCSV_ROWS[1],
    "fcsv in 1": FCSV.format(system="1") + FCSV_ROWS[1],
    "fcsv in RAS": FCSV.format(system="RAS") + FCSV_ROWS[-1],
    "fcsv in 0": FCSV.format(system="0") + FCSV_ROWS[-1],
    "fcsv of an old version": OLD_FCSV,
    **{f"the name {new}": rows().replace(name, new) for new, name in zip(RENAMED, POINTS, strict=True)},
    "names with spaces between spaces": rows(" ").replace("_notch", " notch"),
}
KNOWN = {name: (name.replace("_", " ").title(), "") for name in [*POINTS, "xiphoid"]}


def assert_the_points(data: bytes) -> None:
    places, unit = read_landmarks(data)
    found = by_known_names(places, KNOWN)
    assert {name: place.tolist() for name, place in found.items()} == POINTS
    assert unit in (None, "mm")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"])
@pytest.mark.parametrize("name", TABLES)
def test_a_table_is_read_however_people_keep_it(name: str, encoding: str) -> None:
    remark = "# gepickt für Müller\n" if not TABLES[name].startswith("#") else ""
    for ends in ("\n", "\r\n"):
        assert_the_points((remark + TABLES[name]).replace("\n", ends).encode(encoding))


@pytest.mark.parametrize(
    "text", ["nipple_L,0,037,1443,033,-7,619\n", "name,x,y,z\nnipple_L,0,037,1443,033,-7,619\n", FCSV + "a,1,2\n"]
)
def test_a_table_that_can_mean_two_things_is_refused(text: str) -> None:
    with pytest.raises(BadLandmarks, match=r"\.$"):
        read_landmarks(text.encode())


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("nipple_L", "nipple_L"),
        ("NIPPLE_LEFT", "nipple_L"),
        ("left nipple", "nipple_L"),
        ("Nipple-R", "nipple_R"),
        ("NippleRight", "nipple_R"),
        ("suprasternal notch", "suprasternal_notch"),
        ("SuprasternalNotch", "suprasternal_notch"),
        ("Incisura jugularis", "suprasternal_notch"),
        ("nipple", "nipple"),
        ("nipple left right", "nipple left right"),
        ("nose", "nose"),
        ("", ""),
    ],
)
def test_a_landmark_is_known_by_the_names_that_people_write(written: str, meant: str) -> None:
    known = {
        "nipple_L": ("Left nipple", ""),
        "nipple_R": ("Right nipple", ""),
        "suprasternal_notch": ("Suprasternal notch", "Incisura jugularis"),
    }
    assert known_name(written, known) == meant


TERMS = {
    "suprasternal_notch": "Jugulum, Incisura jugularis, Fourchette sternale, sternal notch, jugular_notch",
    "mid_sternum": "Sternummitte, Mitte des Sternums, milieu du sternum",
    "xiphoid": "Schwertfortsatz, Processus xiphoideus, processus xiphoïde, xiphoid process",
    "midclavicle_L": "Klavikulamitte links, linke Claviculamitte, Schluesselbeinmitte li., milieu claviculaire gauche",
    "midclavicle_R": "rechte Schlüsselbeinmitte, milieu de la clavicule droite, R midclavicular point",
    "acromion_L": "Akromion links, AKROMION_L, acromion gauche, linkes Akromion",
    "acromion_R": "Schulterhöhe re, acromion droit, Akromion (rechts)",
    "nipple_L": "Mamille links, linke Brustwarze, mamelon gauche, MamilleL, Mamille li, mamelon G",
    "nipple_R": "Mamille rechts, rechte Mamille, mamelon droit, mamelon (D), Mamille re.",
    "inframammary_fold_L": "Submammarfalte links, linke Submammärfalte, IMF L, sillon sous-mammaire gauche",
    "inframammary_fold_R": "Inframammaerfalte rechts, Unterbrustfalte re, sillon sous mammaire droit",
    "umbilicus": "Nabel, Bauchnabel, ombilic, l'ombilic, l\u2019ombilic, nombril, navel",
}


@pytest.mark.parametrize("meant", TERMS)
def test_a_landmark_is_known_in_german_and_french(meant: str) -> None:
    known = dict.fromkeys(TERMS, ())
    for written in TERMS[meant].split(", "):
        assert known_name(written, known) == meant


@pytest.mark.parametrize("written", ["Mamille", "mamelon", "Mamille links rechts", "linker Nabel", "Leiste links"])
def test_a_term_without_its_side_or_of_something_else_is_not_known(written: str) -> None:
    assert known_name(written, dict.fromkeys(TERMS, ())) == written


PREAMBLES = {
    "semicolons": "Nr: 12\nDatum;27.11.2026\n\nBezeichnung;X [mm];Y [mm];Z [mm]\nJugulum;1,5;2,5;3,5\nNabel;4;5;6\n",
    "commas": "By a program,version 3\nDate,2026-11-27\nPoints,2\nname,x,y,z\nJugulum,1.5,2.5,3.5\nNabel,4,5,6\n",
    "an index": 'Scan 7\n"Nr","Punkt","x","y","z"\n1,Jugulum,1.5,2.5,3.5\n2,Nabel,4,5,6\n',
    "tabs": "Made by hand\nRepère\tX\tY\tZ\nJugulum\t1.5\t2.5\t3.5\nNabel\t4\t5\t6\n",
    "no names of columns": "Landmarks\nof the standing scan\nJugulum;1,5;2,5;3,5\nNabel;4;5;6\n",
    "more columns than names": "Landmarks\nof the standing scan\nJugulum;1,5;2,5;3,5;sure\nNabel;4;5;6;unsure\n",
    "Landmark Editor": "Version 1.0\n3\nJugulum 1.5 2.5 3.5\nNabel 4 5 6\nMamille 9999 9999 9999\n",
    "lmk": "Landmarks-1.0\n3\nJugulum\n1.5 2.5 3.5 1 1\nNabel\n4 5 6 1 1\nMamille\n0 0 0 0 1\n",
}


@pytest.mark.parametrize("name", PREAMBLES)
def test_lines_before_a_table_are_passed_by(name: str) -> None:
    places, unit = read_landmarks(PREAMBLES[name].encode())
    assert {key: place.tolist() for key, place in places.items()} == {"Jugulum": [1.5, 2.5, 3.5], "Nabel": [4, 5, 6]}
    assert unit == ("mm" if name == "semicolons" else None)


@pytest.mark.parametrize("first", ["nipple_L,1,2", "nipple_L,1,2,"])
def test_a_first_row_that_lacks_a_number_is_no_preamble(first: str) -> None:
    with pytest.raises(BadLandmarks, match="needs three numbers"):
        read_landmarks(f"{first}\nxiphoid,1,2,3\n".encode())
    with pytest.raises(BadLandmarks, match="needs three numbers"):
        read_landmarks(f"Jugulum,1,2,3\n{first}\nname,x,y,z\nxiphoid,1,2,3\n".encode())


def test_one_landmark_under_two_names_is_refused() -> None:
    with pytest.raises(BadLandmarks, match=r'"nipple_L" stands twice in this file, once as "left nipple"'):
        by_known_names({"nipple_L": 1, "left nipple": 2}, KNOWN)


@pytest.mark.parametrize(("scale", "metres"), [(1.0, 0.001), (0.1, 0.01), (0.001, 1.0)])
def test_a_file_without_a_unit_is_in_the_only_one_in_which_it_lies_on_the_scan(scale: float, metres: float) -> None:
    places = {name: scale * np.array(place) for name, place in POINTS.items()}
    box = np.array([-0.2, -0.3, -0.1]), np.array([0.2, 0.3, 0.1])
    assert metres_per_unit(places, None, 1.0, box) == metres
    assert metres_per_unit(places, None, metres, box) == metres
    assert metres_per_unit(places, "mm", 1.0, box) == 0.001
    assert metres_per_unit({"a": np.array([1e5, 0.0, 0.0])}, None, 1.0, box) == 1.0  # refused later, in the scan's unit


def test_our_file_may_say_of_which_size_of_the_scan_it_is() -> None:
    places = {"nipple_L": np.array([100.0, 0.0, 50.0])}
    content = landmark_file(places, "json", "mm", marks={"dot": np.array([10.0, 0.0, 0.0])}, scale=1.25)
    for scale, x in ((1.0, 80.0), (1.25, 100.0), (1.1, 88.0)):
        found = landmarks_of_file(content, no_scan, scale=scale)
        assert found.points_mm["nipple_L"][0] == pytest.approx(x)
        assert found.marks_mm["dot"][0] == pytest.approx(x / 10.0)
    without = landmark_file(places, "json", "mm")
    assert landmarks_of_file(without, no_scan, scale=1.1).points_mm["nipple_L"][0] == 100.0
    others = json.dumps({"landmarks": {"nipple_L": [100.0, 0.0, 50.0]}, "unit": "mm", "scale": 7.0}).encode()
    assert landmarks_of_file(others, no_scan).points_mm["nipple_L"][0] == 100.0, "another program's word"
    for wrong in (0.0, -1.0, True, "1"):
        document = json.loads(content) | {"scale": wrong}
        with pytest.raises(BadLandmarks, match='"scale" in this landmark file is no number above 0'):
            landmarks_of_file(json.dumps(document).encode(), no_scan)


def no_scan() -> Any:
    raise AssertionError("the file names its unit")
