"""OFF and 3MF: the same body in the forms that programs write, and hostile ones."""

import numpy as np
import pytest
import trimesh
from helpers.mesh_variants import FACES, JPEG, OF_FACES, OF_VERTICES, VERTICES, saved
from helpers.other_meshes import colours, coordinates, mesh_xml, model_xml, off, three_mf
from helpers.scan_files import zipped
from PIL import Image
from scan.test_mesh_variants import assert_same_body

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.formats import off as off_module
from breastrig.scan.formats import threemf
from breastrig.scan.piece import PARTLY_COLOURED
from breastrig.scan.read import read_scan

HEAD = "{points} {faces} 0\n"
NORMALS = np.tile([0.0, 0.0, 1.0], (len(VERTICES), 1))
OFF = {
    "plain": (off(), False),
    "numbers in the first line": (off("OFF {points} {faces} 0\n"), False),
    "remarks": (off("# made by a program\n\nOFF # first\n# more\n" + HEAD), False),
    "no edges": (off("OFF\n{points} {faces}\n"), False),
    "windows": (off().replace(b"\n", b"\r\n"), False),
    "decimal commas": (off(number="{:.6f}").replace(b".", b","), False),
    "trimesh": (trimesh.Trimesh(VERTICES, FACES, process=False).export(file_type="off").encode(), False),
    "colours of points": (off("COFF\n" + HEAD, np.column_stack([OF_VERTICES, 0 * OF_VERTICES[:, :1] + 255])), True),
    "colours to 1": (off("COFF\n" + HEAD, OF_VERTICES / 255.0), True),
    "normals": (off("NOFF\n" + HEAD, NORMALS), False),
    "normals and colours": (off("CNOFF\n" + HEAD, np.column_stack([NORMALS, OF_VERTICES])), True),
    "places in a picture": (off("STOFF\n" + HEAD, NORMALS[:, :2]), False),
    "colours of faces": (off(of_faces=OF_FACES), True),
    "colours of faces to 1": (off(of_faces=np.column_stack([OF_FACES / 255.0, np.ones(len(FACES))])), True),
}


@pytest.mark.parametrize("name", OFF)
def test_an_off_is_read_with_its_colours(name: str) -> None:
    data, coloured = OFF[name]
    for scan in (read_scan(data, "off"), read_scan(zipped({"scan.off": data}))):
        assert_same_body(scan, coloured)
        assert scan.notes == ()


def test_quads_and_lines_of_an_off() -> None:
    head, body = off().split(b"\n", 2)[:2], off().split(b"\n", 2)[2].split(b"\n")
    head[1] = b"%d %d 0" % (len(VERTICES), len(FACES) + 2)
    body[len(VERTICES) : len(VERTICES)] = [b"2 0 1", b"1 5"]
    scan = read_scan(b"\n".join([*head, *body]))
    assert_same_body(scan, coloured=False)
    assert scan.notes == ("2 faces of this file have fewer than three corners and were left out.",)
    quads = [b"4 %d %d %d %d" % (k, k + 1, k + 13, k + 12) for k in range(150)]
    lines = off("OFF\n{points} 150 0\n").split(b"\n")[: 2 + len(VERTICES)]
    assert len(read_scan(b"\n".join([*lines, *quads])).faces) == 300


def test_colours_of_an_off_that_are_left_out_are_said() -> None:
    assert read_scan(off(of_faces=np.ones((len(FACES), 1)))).notes == (off_module.COLOURS_LEFT,)
    lines = off(of_faces=OF_FACES).split(b"\n")
    lines[-2] = b" ".join(lines[-2].split()[:4])
    assert read_scan(b"\n".join(lines)).notes == (PARTLY_COLOURED,)


@pytest.mark.parametrize(
    ("data", "word"),
    [
        (b"OFF BINARY\n" + bytes(500), "binary"),
        (off("4OFF\n" + HEAD), "more than three dimensions"),
        (off("nOFF\n3\n" + HEAD), "more than three dimensions"),
        (off()[:-500], "damaged or cut off"),
        (off("OFF\n{points}\n"), "damaged or cut off"),
        (off("OFF\n-4 10 0\n"), "damaged or cut off"),
        (off().replace(b"\n3 ", b"\n9 "), "damaged or cut off"),
        (off().replace(b"3 0 1", b"3 0 9999"), "vertices that do not exist"),
        (off("OFF\n99999999 99999999 0\n"), "triangles allowed"),
    ],
)
def test_an_off_that_cannot_be_read_is_refused(data: bytes, word: str) -> None:
    with pytest.raises((BadScan, TooLarge), match=word):
        read_scan(data)


def one(triangle: str = "", resources: str = "", **more: object) -> bytes:
    return three_mf(model_xml(f'{resources}<object id="1" type="model">{mesh_xml(triangle)}</object>', **more))


TEXTURED = '<m:texture2d id="7" path="/3D/Textures/skin.jpg" contenttype="image/jpeg"/>' + coordinates(8, 7)
MOVED = "0 1 0 -1 0 0 0 0 1 0 0 0"  # a quarter turn about z
BACK = "0 -1 0 1 0 0 0 0 1 0 0 0"
WHOLE = f'<object id="1">{mesh_xml()}</object>'
THREE_MF = {
    "plain": (one(), False),
    "no unit": (one(unit=None), False),
    "metres": (three_mf(model_xml(f'<object id="1">{mesh_xml(scale=1.0)}</object>', unit="meter")), False),
    "microns": (three_mf(model_xml(f'<object id="1">{mesh_xml(scale=1e6)}</object>', unit="micron")), False),
    "inches": (three_mf(model_xml(f'<object id="1">{mesh_xml(scale=1 / 0.0254)}</object>', unit="inch")), False),
    "components": (
        three_mf(model_xml(
            f'{WHOLE}<object id="2"><components><component objectid="1" transform="{MOVED}"/></components></object>',
            f'<item objectid="2" transform="{BACK}"/>',
        )), False,
    ),
    "another part of the package": (
        three_mf(
            model_xml(
                '<object id="2"><components><component objectid="1" p:path="/3D/Objects/object_1.model"/>'
                "</components></object>", '<item objectid="2"/>',
            ), {"3D/Objects/object_1.model": model_xml(WHOLE, "")},
        ), False,
    ),
    "supports are left out": (
        three_mf(model_xml(
            WHOLE + f'<object id="2" type="support">{mesh_xml()}</object>', '<item objectid="1"/><item objectid="2"/>',
        )), False,
    ),
    "nothing is built": (three_mf(model_xml(WHOLE, "")), False),
    "colours of corners": (one('pid="5" p1="{a}" p2="{b}" p3="{c}"', colours(5, OF_VERTICES)), True),
    "colours of triangles": (one('pid="5" p1="{k}"', colours(5, OF_FACES)), True),
    "base materials": (
        one('pid="5" p1="{k}"', '<basematerials id="5">' + "".join(
            '<base name="x" displaycolor="#{:02x}{:02x}{:02x}"/>'.format(*row) for row in OF_FACES.tolist()
        ) + "</basematerials>"), True,
    ),
    "a texture": (
        three_mf(
            model_xml(TEXTURED + '<object id="1" pid="8">' + mesh_xml('p1="{a}" p2="{b}" p3="{c}"') + "</object>"),
            {"3D/Textures/skin.jpg": JPEG},
        ), True,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", THREE_MF)
def test_a_3mf_is_read_with_its_unit_and_colours(name: str) -> None:
    data, coloured = THREE_MF[name]
    for scan in (read_scan(data, "3mf"), read_scan(zipped({"scan.3mf": data}))):
        assert_same_body(scan, coloured)
        assert scan.notes == ()
        assert scan.unit == {"metres": "m", "inches": "in"}.get(name, "mm")


def test_a_mirrored_part_of_a_3mf_is_turned() -> None:
    data = three_mf(model_xml(WHOLE, '<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>'))
    np.testing.assert_array_equal(read_scan(data).faces, FACES[:, ::-1])


def test_colours_of_a_3mf_that_are_not_read_are_said() -> None:
    composite = '<m:compositematerials id="5" matid="3"><m:composite values="1 0"/></m:compositematerials>'
    assert read_scan(one('pid="5" p1="0"', composite)).notes == (threemf.OTHER_COLOURS,)
    lost = three_mf(model_xml(TEXTURED + '<object id="1" pid="8">' + mesh_xml('p1="{a}"') + "</object>"))
    assert "not beside it" in read_scan(lost).notes[0]


def nested(depth: int, width: int) -> bytes:
    rows = [
        f'<object id="{k + 2}"><components>' + f'<component objectid="{k + 1}"/>' * width + "</components></object>"
        for k in range(depth)
    ]
    return three_mf(model_xml(WHOLE + "".join(rows), f'<item objectid="{depth + 1}"/>'))


SELF = '<object id="2"><components><component objectid="2"/></components></object>'
ENTITIES = b'<!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;&b;">]>'


@pytest.mark.parametrize(
    ("data", "word"),
    [
        (nested(40, 2), "more than 2,000 parts"),
        (nested(500, 1), "more than 2,000 parts"),
        (three_mf(model_xml(SELF, '<item objectid="2"/>')), "more than 2,000 parts"),
        (three_mf(model_xml(WHOLE).replace(b"?>", b"?>" + ENTITIES)), "document type"),
        (three_mf(model_xml(WHOLE)[:-3000]), "damaged or cut off"),
        (three_mf(model_xml(WHOLE, unit="furlong")), "damaged or cut off"),
        (three_mf(model_xml(WHOLE, '<item objectid="9"/>')), "damaged or cut off"),
        (three_mf(model_xml(WHOLE.replace('v1="0"', 'v1="99999"'))), "vertices that do not exist"),
        (three_mf(model_xml("", '<item objectid="1" p:path="/3D/other.model"/>')), "not in its package"),
        (one('pid="5" p1="9999"', colours(5, OF_FACES)), "damaged or cut off"),
        (zipped({"a.3mf": b"no zip"}), "zip file is cut off"),
        (zipped({"[Content_Types].xml": b"<a/>"}), "holds no mesh"),
    ],
)
def test_a_3mf_that_cannot_be_read_is_refused(data: bytes, word: str) -> None:
    with pytest.raises((BadScan, TooLarge), match=word):
        read_scan(data)


@pytest.mark.parametrize("limit", ["TRIANGLES", "VERTICES", "GLTF_ENTRIES"])
def test_limits_of_a_3mf(limit: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threemf, limit, 3)
    with pytest.raises(TooLarge):
        read_scan(one('pid="5" p1="{k}"', colours(5, OF_FACES)))


def test_a_picture_in_a_3mf_is_checked_like_every_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("breastrig.scan.pictures.texture.IMAGE_PIXELS", 100)
    model = model_xml(TEXTURED + '<object id="1" pid="8">' + mesh_xml('p1="{a}"') + "</object>")
    with pytest.raises(TooLarge):
        read_scan(three_mf(model, {"3D/Textures/skin.jpg": saved("JPEG", Image.new("RGB", (40, 40)))}))
