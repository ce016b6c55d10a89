"""NRRD and MetaImage: labels lie where the header says, and a header that leads elsewhere or lies is one sentence."""

import builtins
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.grid_files import meta_fields, meta_image, nrrd, nrrd_fields, slicer_words, to_lps
from helpers.label_maps import LESION, LESION_WORDS, LOW, PLAIN, RADIUS, SIZES, body_labels, placed_nifti
from helpers.scan_files import zipped

from breastrig.core.errors import BadScan, BadSettings, NeedsAnswer, TooLarge
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan
from breastrig.scan.volumes.answers import checked_answers
from breastrig.scan.volumes.grids import attached
from breastrig.scan.volumes.grids.nrrd import TYPES

PART = np.s_[55:, :, 24:64]  # a breast with the lesion, and what is around it
PART_LOW = LOW + SIZES * [55.0, 0.0, 24.0]
RAS = np.diag([-1.0, -1.0, 1.0, 1.0])
SHEARED = np.array([[2.0, 0.1, 0.3, 0.0], [0.0, 2.0, 0.4, 0.0], [0.05, 0.0, 2.2, 0.0], [0.0, 0.0, 0.0, 1.0]])


def part() -> np.ndarray:
    return np.asfortranarray(body_labels()[PART])


def with_gland() -> np.ndarray:
    """A plane of label 3 through the breast."""
    labels = part()
    plane = labels[:, 38:39]
    plane[plane == 1] = 3
    return labels


def lesion_of(scan: Scan) -> np.ndarray:
    """mm, LPS."""
    (lesion,) = scan.lesions
    assert 1e3 * lesion.radius == pytest.approx(RADIUS, abs=0.1)
    return 1e3 * lesion.center


def vectors(affine: np.ndarray) -> list[str]:
    return ["({})".format(",".join(map(repr, column))) for column in affine[:3].T.tolist()]


@pytest.mark.parametrize("dtype", ["u1", "<i2", ">u2", "<f4", ">f8"])
@pytest.mark.parametrize("is_packed", [True, False])
def test_labels_lie_where_the_header_says_however_they_are_stored(dtype: str, is_packed: bool) -> None:
    labels, affine = part().astype(dtype), to_lps(PART_LOW)
    as_nrrd = nrrd(labels, nrrd_fields(labels, affine, "gzip" if is_packed else "raw"))
    as_meta = meta_image(labels, meta_fields(labels, affine) | {"CompressedData": str(is_packed)})
    for data in (as_nrrd, as_meta, zipped({"scan/Segmentation": as_nrrd})):
        assert lesion_of(read_scan(data)) == pytest.approx(LESION, abs=0.05)


@pytest.mark.parametrize(
    ("space", "to_space"),
    [
        ("right-anterior-superior", RAS),
        ("LAS", np.diag([1.0, -1.0, 1.0, 1.0])),
        ("left-posterior-superior", np.eye(4)),
    ],
)
def test_nrrd_names_its_space_in_words_and_its_axes_may_be_sheared(space: str, to_space: np.ndarray) -> None:
    labels, affine = part(), SHEARED.copy()
    affine[:3, 3] = PART_LOW
    at = (LESION - PART_LOW) / SIZES
    *directions, origin = vectors(to_space @ affine)
    fields = nrrd_fields(labels) | {
        "space": space,
        "space directions": " ".join(directions),
        "space origin": origin,
        "space units": '"mm" "mm" "mm"',
    }
    (lesion,) = read_scan(nrrd(labels, fields)).lesions
    assert 1e3 * lesion.center == pytest.approx((affine @ [*at, 1.0])[:3], abs=0.1)
    metres = fields | {"space units": '"m" "m" "m"'}
    with pytest.raises(BadScan, match="which those of no body are; check its unit"):
        read_scan(nrrd(labels, metres))


def test_segments_of_slicer_may_overlap_and_have_codes_and_names() -> None:
    """Two layers that share labels: the lesion of the second is also body in the first."""
    labels = with_gland()
    layers = np.zeros((2, *labels.shape), np.uint8)
    layers[0] = labels > 0
    layers[1][labels == 2] = 1
    layers[1][labels == 3] = 2
    body, lesion = f"SCT^{PLAIN[1]}^{PLAIN[2]}", f"SCT^{LESION_WORDS[1]}^{LESION_WORDS[2]}"
    mass = f"SCT^{LESION_WORDS[3]}^{LESION_WORDS[4]}"
    words = slicer_words([("Brust", 0, 1, body, body), ("Läsion", 1, 1, lesion, mass), ("Drüse", 1, 2, body, body)])
    for data in (
        nrrd(layers, nrrd_fields(layers, to_lps(PART_LOW)), words),
        nrrd(  # the list of layers as the slowest axis
            np.moveaxis(layers, 0, 3),
            nrrd_fields(layers, to_lps(PART_LOW))
            | {
                "sizes": " ".join(map(str, (*labels.shape, 2))),
                "space directions": " ".join([*vectors(to_lps(PART_LOW))[:3], "none"]),
                "kinds": "domain domain domain list",
            },
            words,
        ),
    ):
        scan = read_scan(data)
        assert lesion_of(scan) == pytest.approx(LESION, abs=0.05)
        assert [(each.number, each.taken_as, each.label) for each in scan.segments] == [
            (1, "tissue", "Brust Tissue"),
            (2, "lesion", "Läsion Mass"),
            (3, "tissue", "Drüse Tissue"),
        ]
        assert scan.segments[1].why == "Its codes say so."
        assert "Läsion" not in " ".join(scan.notes)


def test_segments_of_one_layer_have_the_numbers_of_their_labels() -> None:
    labels = 5 * with_gland()
    any_code = f"SCT^{PLAIN[1]}^{PLAIN[2]}"
    words = slicer_words([("body", 0, 5, any_code, any_code), ("Lésion", 0, 10, any_code, any_code)])
    scan = read_scan(nrrd(labels, nrrd_fields(labels, to_lps(PART_LOW)), words))
    assert [(each.number, each.label) for each in scan.segments] == [
        (5, "body Tissue"),
        (10, "Lésion Tissue"),
        (25, ""),
    ]
    assert scan.segments[1].why == "Its name says so."


def test_several_volumes_and_colours_are_no_layers() -> None:
    labels = part()[::4, ::4, ::4]
    several = np.stack([labels, labels, labels])
    with pytest.raises(BadScan, match="must be one volume of three dimensions"):
        read_scan(nrrd(several))
    with pytest.raises(BadScan, match="no single grey value or label"):
        read_scan(nrrd(several, nrrd_fields(several) | {"kinds": "RGB-color domain domain domain"}))
    with pytest.raises(BadScan, match="no single grey value or label"):
        read_scan(b"ObjectType = Image\n" + meta_image(labels, {"ElementNumberOfChannels": "3"} | meta_fields(labels)))


def without(fields: dict[str, str], *names: str) -> dict[str, str]:
    return {name: value for name, value in fields.items() if name not in names}


def test_a_side_that_no_header_names_is_asked() -> None:
    labels, step = np.asfortranarray(body_labels()), SIZES
    affine = to_lps(LOW, step)
    of_nrrd, of_meta = nrrd_fields(labels, affine), meta_fields(labels, affine)
    middle = LOW + 0.5 * step * (np.array(labels.shape) - 1)
    spaced = without(of_nrrd, "space", "space directions", "space origin") | {"spacings": " ".join(map(str, step))}
    for data in (
        nrrd(labels, {**without(of_nrrd, "space"), "space dimension": "3"}),
        nrrd(labels, of_nrrd | {"space": "scanner-xyz"}),
        nrrd(labels, spaced),
        meta_image(labels, of_meta | {"AnatomicalOrientation": "???"}),
        meta_image(labels, of_meta | {"AnatomicalOrientation": "LAI"}),  # another side than the matrix says
        meta_image(labels, without(of_meta, "TransformMatrix")),
    ):
        with pytest.raises(NeedsAnswer, match="does not say which side is left") as caught:
            read_scan(data)
        assert caught.value.question["field"] == "frame"
        assert {"LPS", "RPS"} <= {each["value"] for each in caught.value.question["choices"]}
        scan = read_scan(data, answers=checked_answers("LPS"))
        assert lesion_of(scan) == pytest.approx(LESION - middle, abs=0.2)
        with pytest.raises(BadSettings, match="no sform to be taken"):
            read_scan(data, answers=checked_answers("sform"))
    with pytest.raises(BadSettings, match=r"says itself where its voxels lie \(LPS\), and not as RAS"):
        read_scan(nrrd(labels, of_nrrd), answers=checked_answers("RAS"))


SECRET = "0123456789 nothing of this may come back"


def opened_files(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of all files that are opened from now on."""
    opened, original = list[str](), builtins.open

    def noted(file: Any, *rest: Any, **options: Any) -> Any:
        opened.append(str(file))
        return original(file, *rest, **options)

    monkeypatch.setattr("builtins.open", noted)
    monkeypatch.setattr("io.open", noted)
    return opened


@pytest.mark.parametrize(
    "line",
    ["data file: {}", "datafile: {}", "data file: LIST\n{}", "data file: {}/%03d.raw 1 40 1", "DATA FILE: {}"],
)
@pytest.mark.parametrize("blank", ["\n\n", ""])
def test_an_nrrd_that_names_another_file_is_refused_before_anything_is_opened(
    line: str, blank: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    secret = tmp_path / "secret"
    secret.write_text(SECRET)
    fields = nrrd_fields(part()) | {"encoding": "raw"}
    lines = ["NRRD0004", *(f"{name}: {value}" for name, value in fields.items()), line.format(secret)]
    data = ("\n".join(lines) + blank).encode()
    opened = opened_files(monkeypatch)
    with pytest.raises(BadScan, match=re.escape(attached.DETACHED.format(".nrrd"))):
        read_scan(data)
    assert str(secret) not in opened


@pytest.mark.parametrize("named", ["{}", "LIST\n{}", "{}/%03d.raw 1 40 1", "LOCAL.raw", ""])
def test_a_meta_image_that_names_another_file_is_refused_before_anything_is_opened(
    named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    secret = tmp_path / "secret"
    secret.write_text(SECRET)
    data = meta_image(part(), meta_fields(part()) | {"ElementDataFile": named.format(secret)})
    opened = opened_files(monkeypatch)
    with pytest.raises(BadScan, match=re.escape(attached.DETACHED.format(".mha"))):
        read_scan(data)
    assert str(secret) not in opened


def test_headers_that_lie_are_refused_before_anything_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    labels = part()
    of_nrrd, of_meta = nrrd_fields(labels, to_lps(PART_LOW)), meta_fields(labels, to_lps(PART_LOW))
    monkeypatch.setattr(attached, "inflated", None)
    sizes = "This volume has more than the 134,217,728 voxels allowed"
    damaged, cut = "The header of this {} file is damaged or cut off", "does not say where its voxels lie"
    nan = "(nan,0,0) (0,1.1,0) (0,0,2)"
    for change, error, sentence in (
        ({"sizes": "999999999 999999999 9"}, TooLarge, sizes),
        ({"sizes": "-40 104 40"}, BadScan, damaged.format("NRRD")),
        ({"sizes": "0 104 40"}, BadScan, damaged.format("NRRD")),
        ({"sizes": "4294967256000000 104 40"}, BadScan, damaged.format("NRRD")),
        ({"dimension": "4"}, BadScan, damaged.format("NRRD")),
        ({"space directions": nan}, BadScan, cut),
        ({"space directions": "(0,0,0) (0,1.1,0) (0,0,2)"}, BadScan, cut),
        ({"space directions": "(1,0,0) (0,1.1,0)"}, BadScan, damaged.format("NRRD")),
        ({"space directions": "(1,0) (0,1.1) (0,0)"}, BadScan, damaged.format("NRRD")),
        ({"type": "block"}, BadScan, "no single grey value or label"),
        ({"type": "float128"}, BadScan, damaged.format("NRRD")),
        ({"encoding": "bzip2"}, BadScan, "neither raw nor packed with gzip"),
        ({"encoding": "hex"}, BadScan, "neither raw nor packed with gzip"),
        ({"byte skip": "-1"}, BadScan, "leaves out bytes before its voxels"),
        ({"space units": '"furlong" "mm" "mm"'}, BadScan, "a unit of length that is not read"),
    ):
        fields = of_nrrd | change
        with pytest.raises(error, match=sentence):
            read_scan(
                nrrd(labels, fields | {"encoding": "raw"}).replace(
                    b"encoding: raw", f"encoding: {fields['encoding']}".encode()
                )
            )
    for change, error, sentence in (
        ({"DimSize": "999999999 999999999 9"}, TooLarge, sizes),
        ({"DimSize": "-40 104 40"}, BadScan, damaged.format("MetaImage")),
        ({"DimSize": "150 104"}, BadScan, damaged.format("MetaImage")),
        ({"ElementSpacing": "nan 1.1 2"}, BadScan, cut),
        ({"ElementSpacing": "-1 1.1 2"}, BadScan, "does not say how large its voxels are"),
        ({"ElementSpacing": "0 1.1 2"}, BadScan, "does not say how large its voxels are"),
        ({"BinaryData": "False"}, BadScan, "written as text"),
        ({"ElementType": "MET_OTHER"}, BadScan, "no single grey value or label"),
        ({"HeaderSize": "-1"}, BadScan, damaged.format("MetaImage")),
    ):
        fields = change | without(of_meta, *change)
        with pytest.raises(error, match=sentence):
            read_scan(b"ObjectType = Image\n" + meta_image(labels, fields))
    with pytest.raises(BadScan, match="does not name the order of its bytes"):
        read_scan(nrrd(labels.astype("<i2"), without(nrrd_fields(labels.astype("<i2")), "endian")))
    assert TYPES["signed char"] == "i1"


def test_voxels_that_are_cut_off_or_swell_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    labels = part()
    bomb = nrrd(np.zeros((600, 600, 300), np.uint8), nrrd_fields(labels, to_lps(PART_LOW)))  # 100 kB
    with pytest.raises(BadScan, match="This label map shows no skin"):  # no more is unpacked than the header says
        read_scan(bomb)
    for data in (
        nrrd(labels)[:-100],
        nrrd(labels, nrrd_fields(labels) | {"encoding": "raw"})[:-1],
        meta_image(labels)[:-100],
        meta_image(labels, meta_fields(labels) | {"CompressedData": "False"})[:-1],
        nrrd(labels, nrrd_fields(labels) | {"encoding": "raw"}).replace(b"encoding: raw", b"encoding: gzip"),
    ):
        with pytest.raises(BadScan, match="The voxels of this file are damaged or cut off"):
            read_scan(data)
    monkeypatch.setattr(attached, "LABEL_MAP_BYTES", 1000)
    for data in (nrrd(labels), meta_image(labels)):
        with pytest.raises(TooLarge, match="have more than the 0 MB allowed"):
            read_scan(data)


def test_the_same_lesion_in_all_grid_formats(tmp_path: Path) -> None:
    labels = part()
    affine = to_lps(PART_LOW)
    written = {
        "a.nii": placed_nifti(labels, (RAS @ affine, 1), (RAS @ affine, 1)),
        "b.seg.nrrd": nrrd(labels, nrrd_fields(labels, affine)),
        "c.mha": meta_image(labels, meta_fields(labels, affine)),
    }
    scans = []
    for name, data in written.items():
        (tmp_path / name).write_bytes(data)
        scans.append(read_scan(tmp_path / name))
    for scan in scans[1:]:
        assert scan.vertices == pytest.approx(scans[0].vertices, abs=1e-7)
        assert scan.notes == scans[0].notes
        assert lesion_of(scan) == pytest.approx(lesion_of(scans[0]), abs=1e-4)
