"""Lesions of a file of their own lie in the image that they were drawn on, or a person is asked."""

import base64
import gzip
import io
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers import dicom_files
from helpers.grid_files import meta_fields, meta_image, nrrd, nrrd_fields, slicer_words, to_lps
from helpers.label_maps import LESION, LOW, SIZES, body_labels, file_of, nifti, placed_nifti, places, seg
from helpers.mr_image import MrImage, mr_image
from helpers.scan_files import zipped
from helpers.structure_sets import Region, ball, circle, structure_set, structures
from PIL import Image

from breastrig.core.errors import BadScan, BadSettings, NeedsAnswer
from breastrig.geometry.normals import face_normals
from breastrig.scan.images.added_lesions import LesionsRead
from breastrig.scan.images.image import kept_image
from breastrig.scan.images.read_lesions import lesions_in
from breastrig.scan.images.read_volumes import pieces_of
from breastrig.scan.images.same_place import tissue_of
from breastrig.scan.kept_image import KeptImage
from breastrig.scan.read import read_scan
from breastrig.scan.volumes.answers import NOTHING_SAID, checked_answers
from breastrig.scan.volumes.volume import frame_digest

RAS = np.diag([-1.0, -1.0, 1.0, 1.0])
FRAME = "1.2.3.4"
YES, NO = checked_answers(None, same_place="yes"), checked_answers(None, same_place="no")


@cache
def image() -> MrImage:
    return mr_image("plain")


@cache
def kept(frame: str = "") -> KeptImage:
    found = kept_image(image().image)
    return KeptImage(found.values, found.affine, frame_digest(frame))


def mask() -> np.ndarray:
    return np.asfortranarray(image().lesion.astype(np.uint8))


def affine(moved: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    found = image().image.affine.copy()
    found[:3, 3] += moved
    return found


def as_nrrd(labels: np.ndarray, place: np.ndarray) -> bytes:
    return nrrd(labels, nrrd_fields(labels, place))


def as_nifti(labels: np.ndarray, place: np.ndarray) -> bytes:
    return placed_nifti(labels, (RAS @ place, 1), (RAS @ place, 0))


def check(found: LesionsRead, off: float = 0.5) -> None:
    """The one lesion lies where it is; mm."""
    (lesion,) = found.lesions
    assert lesion.center == pytest.approx(image().lesion_at, abs=off)
    volume = image().lesion.sum() * abs(np.linalg.det(affine()[:3, :3]))
    assert lesion.radius == pytest.approx(np.cbrt(3.0 * volume / (4.0 * np.pi)), abs=0.1)


def up(distance: float) -> np.ndarray:
    return np.array([0.0, 0.0, distance])


def asked(data: bytes, on: KeptImage) -> NeedsAnswer:
    with pytest.raises(NeedsAnswer) as caught:
        lesions_in(data, on, NOTHING_SAID)
    question = caught.value.question
    assert (question["field"], [each["value"] for each in question["choices"]]) == ("same_place", ["yes", "no"])
    return caught.value


@pytest.mark.parametrize(
    "write", [as_nrrd, as_nifti, lambda labels, place: meta_image(labels, meta_fields(labels, place))]
)
def test_a_map_of_the_lesion_alone_on_the_image_s_grid(write) -> None:
    found = lesions_in(write(mask(), affine()), kept(), NOTHING_SAID)
    check(found)
    (segment,) = found.segments
    assert (segment.taken_as, segment.why) == ("lesion", "It is the only segment.")
    assert any("was assumed from their place" in note for note in found.notes)


def test_the_same_voxels_in_another_order_and_a_cut_of_the_grid() -> None:
    turned = nifti(mask(), turned=True, low=affine()[:3, 3], sizes=np.full(3, 3.0))
    check(lesions_in(turned, kept(), NOTHING_SAID))
    low = np.argwhere(mask()).min(axis=0) - 3
    part = np.asfortranarray(mask()[low[0] : low[0] + 12, low[1] : low[1] + 12, low[2] : low[2] + 12])
    check(lesions_in(as_nrrd(part, affine(tuple(3.0 * low))), kept(), NOTHING_SAID))


def test_a_grid_that_is_the_image_s_but_moved_by_more_than_a_slice_is_asked() -> None:
    """Also where the image was kept in blocks of its voxels, and the file's axes run the other way."""
    fine = KeptImage(kept().values[:137:2, :, ::2], kept().affine @ np.diag([2.0, 1.0, 2.0, 1.0]))
    half = np.diag([1.0, 1.0, 1.0, 1.0])
    half[:3, 3] = [0.5, 0.0, 0.5]
    blocks = KeptImage(fine.values, kept().affine @ half @ np.diag([2.0, 1.0, 2.0, 1.0]))
    flipped = affine()
    flipped[:3, 3] += affine()[:3, 0] * (mask().shape[0] - 1)
    flipped[:3, 0] *= -1.0
    for on in (kept(), blocks):
        for labels, place in ((mask(), affine()), (np.asfortranarray(mask()[::-1]), flipped)):
            check(lesions_in(as_nrrd(labels, place), on, NOTHING_SAID))
            near, far = place.copy(), place.copy()
            near[2, 3] += 2.0
            far[2, 3] += 7.0
            assert lesions_in(as_nrrd(labels, near), on, NOTHING_SAID).lesions
            error = asked(as_nrrd(labels, far), on)
            assert str(error).startswith("The grid of these lesions is the image's, moved by 7 mm; say which it is: ")
            found = lesions_in(as_nrrd(labels, far), on, YES)
            assert found.lesions[0].center == pytest.approx(image().lesion_at + up(7.0), abs=0.5)
            assert any(note.startswith("A person said that these lesions lie where") for note in found.notes)
            with pytest.raises(BadScan, match="do not lie where the image does; export them from the series"):
                lesions_in(as_nrrd(labels, far), on, NO)


def red_in(error: NeedsAnswer) -> np.ndarray:
    """Where the mark's middle is in the picture, as shares of its width and height."""
    start, _, content = error.question["choices"][0]["picture"].partition(",")
    assert start == "data:image/png;base64"
    pixels = np.asarray(Image.open(io.BytesIO(base64.b64decode(content))).convert("RGB")).astype(int)
    marked = np.argwhere((pixels[..., 0] > 200) & (pixels[..., 1] < 100))
    return np.asarray((marked.mean(axis=0) / pixels.shape[:2])[::-1])


def test_a_lesion_in_the_air_or_outside_of_the_image_is_asked_with_a_picture() -> None:
    forwards = -1.0 - mr_front()
    for moved, word in (((0.0, forwards, 0.0), "in the air"), ((0.0, 0.0, 400.0), "outside")):
        part = np.asfortranarray(mask()[:-1])  # another grid than the image's
        error = asked(as_nrrd(part, affine(moved)), kept())
        assert str(error).startswith(f"Lesion 1 lies {word} of the image; say which it is")
        place = image().lesion_at + moved
        size = 3.0 * np.array(mask().shape)
        share = (place - affine()[:3, 3] + 1.5) / size
        if word == "in the air":
            assert red_in(error) == pytest.approx(share[:2], abs=0.02)


def mr_front() -> float:
    """mm from the lesion to the air in front of the field of view's first voxels."""
    return float(image().lesion_at[1] - affine()[1, 3] - 12.0)


def test_tissue_holds_what_spoils_images() -> None:
    for option in ("fat suppressed", "one coil half at 30 %", "three times the noise"):
        spoiled = mr_image(option)
        tissue = tissue_of(kept_image(spoiled.image))
        front = spoiled.image.affine[:3, 3] + [200.0, 3.0, 100.0]
        within, inside = tissue.at(np.array([spoiled.lesion_at, front, front - 900.0]))
        assert (within.tolist(), inside.tolist()) == ([True, True, False], [True, False, False])


def test_another_frame_of_reference_is_asked_and_the_same_is_not() -> None:
    regions = [ball(image().lesion_at, 9.0, step=3.0)]
    packed = zipped({"DICOM/IM000001": structures(regions, FRAME), "README.txt": b"Hello"})
    assert len(lesions_in(packed, kept(FRAME), NOTHING_SAID).lesions) == 1
    ours, other = structures(regions, FRAME), structures(regions, "1.2.3.5")
    found = lesions_in(ours, kept(FRAME), NOTHING_SAID)
    assert not any("assumed" in note for note in found.notes)
    assert str(asked(other, kept(FRAME))).startswith("These lesions were drawn in another frame of reference")
    assert lesions_in(other, kept(FRAME), YES).lesions
    assert lesions_in(other, kept(), NOTHING_SAID).lesions  # an image that names none
    dataset = seg({1: mask() > 0}, {1: ("Tumour", "", "", "", "")})
    dataset.FrameOfReferenceUID = FRAME
    assert volume_frame(dataset) == frame_digest(FRAME)
    assert FRAME not in frame_digest(FRAME)


def volume_frame(dataset) -> str:
    from breastrig.scan.volumes.volume import Volume
    from breastrig.scan.volumes.volume_files import read_volume

    found = read_volume(file_of(dataset), "dicom", None)
    assert isinstance(found, Volume)
    return found.frame


def test_a_ball_of_contours_has_its_place_and_size() -> None:
    for radius, step, kind, name in ((9.0, 3.0, "", "x"), (9.0, 1.5, "GTV", "y"), (4.0, 1.0, "", "Läsion")):
        centre = image().lesion_at + np.array([0.3, -0.2, 0.7])
        (lesion,) = lesions_in(structures([ball(centre, radius, step, name, kind)]), kept(), NOTHING_SAID).lesions
        assert lesion.center == pytest.approx(centre, abs=0.2)
        assert lesion.radius == pytest.approx(radius, abs=0.2)


def test_regions_of_a_structure_set_are_what_their_kinds_and_forms_say() -> None:
    at = image().lesion_at
    middle = affine()[:3, 3] + 1.5 * np.array(mask().shape)
    body = Region([circle(np.array([*middle[:2], z]), 80.0) for z in np.arange(342.0, 442.0, 3.0)], "BODY", "EXTERNAL")
    ring = ball(at, 9.0, 3.0, "Läsion links")
    ring.contours.extend(circle(np.array([*at[:2], each[0, 2]]), 2.0) for each in list(ring.contours)[2:4])  # a hole
    margin = ball(at, 14.0, 3.0, "rim", "PTV")
    found = lesions_in(structures([body, ring, margin]), kept(), NOTHING_SAID)
    assert [(each.number, each.taken_as, each.why) for each in found.segments] == [
        (1, "tissue", "Its codes say so."),
        (2, "lesion", "Its name says so."),
        (3, "tissue", "Its codes say so."),
    ]
    (lesion,) = found.lesions
    full = lesions_in(structures([ball(at, 9.0, 3.0)]), kept(), NOTHING_SAID).lesions[0].radius
    assert full**3 - lesion.radius**3 == pytest.approx(0.75 * 4.0 * 3.0 * 2, rel=0.2)
    assert "links" not in " ".join(found.notes)
    none = lesions_in(structures([body, ring]), kept(), checked_answers(None, {1: "unused", 2: "tissue"}))
    assert (none.lesions, [each.taken_as for each in none.segments]) == ((), ["unused", "tissue"])
    assert none.notes[-1].startswith("No segment of this file was taken for a lesion; say which is one")
    with pytest.raises(BadSettings, match="There is no segment 7"):
        lesions_in(structures([ring]), kept(), checked_answers(None, {7: "tissue"}))


def test_a_plane_that_a_region_misses_is_filled_and_said() -> None:
    region = ball(image().lesion_at, 9.0, 3.0)
    body = ball(image().lesion_at, 60.0, 3.0, "all", "ORGAN")
    del region.contours[2]
    found = lesions_in(structures([region, body]), kept(), checked_answers(None, {1: "lesion"}))
    assert found.lesions[0].radius == pytest.approx(9.0, abs=0.3)
    assert "Region 1 has no contour in a plane between others; the neighbours were joined there." in found.notes


def test_contours_that_cannot_be_filled_are_one_sentence() -> None:
    at = image().lesion_at
    flat = Region([circle(at, 9.0)])
    uneven = Region([circle(at + up(z), 9.0) for z in (0.0, 3.0, 7.5, 10.5)])
    bent = Region([circle(at, 9.0) + np.outer(np.arange(60), [0.0, 0.0, 0.05]), circle(at + up(9.0), 9.0)])
    far = Region([circle(at + up(z), 9.0) for z in (0.0, 1e9)])
    for region, sentence in (
        (Region(), "holds no closed contours"),
        (flat, "lie in one plane alone"),
        (uneven, "do not lie in parallel planes at equal distances"),
        (bent, "do not lie in parallel planes"),
        (far, "lie in one plane alone"),
    ):
        with pytest.raises(BadScan, match=sentence):
            lesions_in(structures([region]), kept(), NOTHING_SAID)
    points = structure_set([ball(at, 9.0)])
    for contour in points.ROIContourSequence[0].ContourSequence:
        contour.ContourGeometricType = "POINT"
    with pytest.raises(BadScan, match="holds no closed contours"):
        lesions_in(file_of(points), kept(), NOTHING_SAID)


def test_of_very_many_parts_the_largest_are_taken() -> None:
    """As of what enhances in many spots."""
    labels, place = np.zeros((60, 60, 30), np.uint8), np.diag([1.0, 1.0, 1.0, 1.0])
    for k in range(25):
        at = np.array([6 + 12 * (k % 5), 6 + 12 * (k // 5), 15])
        size = 2 + (k % 7 > 0)
        labels[tuple(slice(each - size, each + size + 1) for each in at)] = 1
    place[:3, 3] = image().lesion_at - 20.0
    found = lesions_in(as_nrrd(labels, place), kept(), YES)
    assert len(found.lesions) == 20
    assert min(each.radius for each in found.lesions) == pytest.approx(np.cbrt(343 * 0.75 / np.pi), abs=0.01)
    assert "5 smaller parts of these lesions were left out; the 20 largest were taken." in found.notes


def test_segments_of_slicer_with_the_lesion_s_code() -> None:
    labels = np.zeros((2, *mask().shape), np.uint8)
    labels[0] = 1
    labels[0, :, :25] = 0
    labels[1] = mask()
    tissue, mass = "SCT^85756007^Tissue", "SCT^4147007^Mass"
    words = slicer_words([("body", 0, 1, tissue, tissue), ("?", 1, 1, tissue, mass)])
    found = lesions_in(nrrd(labels, nrrd_fields(labels, affine()), words), kept(), NOTHING_SAID)
    check(found)
    assert [each.why for each in found.segments] == ["It is larger than a ball of 80 mm.", "Its codes say so."]


def test_what_holds_no_lesion_is_one_sentence() -> None:
    unplaced = placed_nifti(mask(), (np.eye(4), 0), (np.eye(4), 0))
    no_origin = {name: value for name, value in nrrd_fields(mask(), affine()).items() if name != "space origin"}
    grey = np.asfortranarray(image().image.values.astype(np.float32))
    for data, sentence in (
        (unplaced, "does not say where its voxels lie"),
        (nrrd(mask(), no_origin), "does not say where its voxels lie"),
        (as_nrrd(grey, affine()), "This is an image, not a segmentation of lesions"),
        (b"ply\nformat ascii 1.0\n", "This file holds no lesions; give a segmentation"),
        (as_nrrd(mask(), affine())[:-40], "damaged or cut off"),
    ):
        with pytest.raises(BadScan, match=sentence):
            lesions_in(data, kept(), NOTHING_SAID)
    with pytest.raises(BadScan, match="This is an image, not a segmentation of lesions"):
        lesions_in(next(iter(dicom_files.files(dicom_files.Series(image().image)).values())), kept(), NOTHING_SAID)
    with pytest.raises(BadScan, match="does not say where its voxels lie"):
        lesions_in(unplaced, kept(), checked_answers("LPS"))
    with pytest.raises(BadScan, match="This scan was made of no image, so it is not known where lesions"):
        lesions_in(as_nrrd(mask(), affine()), None, NOTHING_SAID)


def test_two_headers_that_contradict_each_other_are_asked_for_the_frame() -> None:
    mirrored = placed_nifti(mask(), (RAS @ affine(), 1), (np.diag([-1.0, 1.0, 1.0, 1.0]) @ RAS @ affine(), 1))
    with pytest.raises(NeedsAnswer, match="contradict each other by left and right") as caught:
        lesions_in(mirrored, kept(), NOTHING_SAID)
    assert caught.value.question["field"] == "frame"
    check(lesions_in(mirrored, kept(), checked_answers("sform")))


def test_lesions_beside_a_body_in_a_label_map() -> None:
    labels = body_labels()
    on = KeptImage(np.asfortranarray((80 * (labels > 0)).astype(np.uint8)), to_lps())
    found = lesions_in(nifti(labels), on, NOTHING_SAID)
    assert [each.taken_as for each in found.segments] == ["tissue", "lesion", "tissue"]


def test_without_an_image_it_is_said_what_is_missing() -> None:
    alone = structures([ball(image().lesion_at, 9.0)])
    for data, sentence in (
        (
            as_nrrd(mask(), affine()),
            "shows no body: all that is in it is 15 mm across, as a lesion alone; give it with the",
        ),
        (alone, r"This is a structure set \(RTSTRUCT\), which shows no skin; give it with its image"),
    ):
        with pytest.raises(BadScan, match=sentence):
            read_scan(data)


def test_a_zip_or_folder_of_an_image_and_its_segmentation(tmp_path: Path) -> None:
    """Of any format on either side: the one image is the scan, the other files are its lesions."""
    grey = np.asfortranarray(image().image.values.astype(np.float32))
    series = dicom_files.Series(image().image)
    dicom = dicom_files.files(series)
    seg_nrrd, seg_dicom = as_nrrd(mask(), affine()), dicom_files.lesion_seg(series, image().lesion)
    for content in (
        {"image.nrrd": as_nrrd(grey, affine()), "Segmentation.seg.nrrd": seg_nrrd},
        {"a/label.nii.gz": gzip.compress(as_nifti(mask(), affine())), "image.nii": as_nifti(grey, affine())},
        {"image.nrrd": as_nrrd(grey, affine()), "SEG": seg_dicom, "notes.txt": b"Hello"},
        dicom | {"Segmentation.seg.nrrd": seg_nrrd},
    ):
        of_dicom = content.keys() >= dicom.keys()
        scan = read_scan(dicom_files.foldered(content, tmp_path / "folder") if of_dicom else zipped(content))
        assert scan.from_image
        (lesion,) = scan.lesions
        assert 1e3 * lesion.center == pytest.approx(image().lesion_at, abs=0.5)
    damaged = read_scan(zipped({"image.nrrd": as_nrrd(grey, affine()), "lesion.seg.nrrd": seg_nrrd[:-40]}))
    assert damaged.lesions == ()
    assert any(note.startswith("A segmentation beside the image was left out: ") for note in damaged.notes)
    with pytest.raises(
        BadScan, match="holds 2 label maps or volumes, and not one image among them; pack one image with"
    ):
        read_scan(zipped({"1.nrrd": as_nrrd(grey, affine()), "2.nrrd": as_nrrd(grey, affine())}))
    with pytest.raises(BadSettings, match="series is for those alone"):
        read_scan(zipped({"1": as_nrrd(grey, affine()), "2": seg_nrrd}), answers=checked_answers(None, series="0"))


def test_a_lesion_in_one_slice_of_a_dicom_segmentation() -> None:
    """A small one; the distance between slices is named, for frames do not show it."""
    body, centre = body_labels(), LESION.copy()
    on = KeptImage(np.asfortranarray((80 * (body > 0)).astype(np.uint8)), to_lps())
    disc = np.zeros(body.shape, np.bool_)
    at = np.rint((centre - LOW) / SIZES).astype(int)
    disc[at[0] - 2 : at[0] + 3, at[1] - 2 : at[1] + 3, at[2]] = True
    for named in ({}, {"spacing": False, "thickness": True}):
        (lesion,) = lesions_in(file_of(seg({1: disc}, **named)), on, NOTHING_SAID).lesions
        assert lesion.center == pytest.approx(centre, abs=1.0)
        assert lesion.radius == pytest.approx(np.cbrt(0.75 / np.pi * 25 * np.prod(SIZES)), abs=0.01)
    with pytest.raises(BadScan, match="is a single slice; export the whole volume"):
        lesions_in(file_of(seg({1: disc}, spacing=False)), on, NOTHING_SAID)


def test_the_chest_wall_is_where_a_muscle_is_named() -> None:
    """A tilted plate 8 mm thick: its front is the wall, and it is no lesion."""
    at = places()
    front = 10.0 + 0.1 * at[..., 0]
    labels = body_labels()
    labels[(at[..., 1] > front - 0.5 * SIZES[1]) & (at[..., 1] < front + 8.0) & (np.abs(at[..., 0]) < 90.0)] = 4
    on = KeptImage(np.asfortranarray((80 * (labels > 0)).astype(np.uint8)), to_lps())
    tissue = "SCT^85756007^Tissue"
    rest = [("Body", 0, 1, tissue, tissue), ("Lesion", 0, 2, tissue, tissue)]
    for name, kind, is_wall in (
        ("Großer Brustmuskel", tissue, True),
        ("Segment_4", "SCT^60005003^Pectoralis major muscle", True),
        ("chest_wall", tissue, True),
        ("pectoral lymph node", tissue, False),
        ("Segment_4", tissue, False),
    ):
        data = nrrd(labels, nrrd_fields(labels), slicer_words([*rest, (name, 0, 4, tissue, kind)]))
        found = lesions_in(data, on, NOTHING_SAID)
        assert found.segments[1].taken_as == "lesion"
        assert found.segments[2].taken_as == "tissue" or not is_wall
        assert (found.wall is not None) == is_wall
        if found.wall is not None:
            vertices, faces = found.wall
            off = (vertices[:, 1] - 10.0 - 0.1 * vertices[:, 0]) / np.hypot(1.0, 0.1)
            assert np.percentile(np.abs(off), 95) < 0.9 * SIZES[1]
            assert np.ptp(vertices[:, 0]) == pytest.approx(180.0, abs=4.0)
            assert face_normals(vertices, faces).mean(axis=0) == pytest.approx(
                np.array([0.1, -1.0, 0.0]) / np.hypot(1.0, 0.1), abs=0.05
            )
        assert (pieces_of(data, "nrrd", "auto", NOTHING_SAID).wall is not None) == is_wall
