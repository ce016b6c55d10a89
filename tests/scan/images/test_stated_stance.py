"""How an MRI's header says that the patient lies, and what becomes of it."""

from pathlib import Path

import pytest
from helpers.dicom_files import Series, file_of, slices
from helpers.image_uploads import IMAGE
from helpers.walled_patient import image, walled_patient
from pydicom.dataset import Dataset

import breastrig
from breastrig.fitting.prepare_scan import prepared_scan
from breastrig.rig.model import Rig
from breastrig.scan.images.dicom_files import one_file
from breastrig.scan.images.dicom_headers import header_of
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.read import read_scan
from breastrig.scan.stored_scan import STORED, write_stored


@pytest.mark.parametrize(
    ("position", "stance"),
    [
        ("HFP", "prone"),
        ("FFP", "prone"),
        ("HFS", "supine"),
        ("FFS", "supine"),
        ("HFDR", None),
        ("PRONE", None),
        ("", None),
    ],
)
def test_the_header_is_read(position: str, stance: str | None) -> None:
    def change(made: Dataset, _at: int) -> None:
        made.PatientPosition = position

    (first, *_) = slices(Series(ImageVolume(IMAGE.values, IMAGE.affine), change=change))
    (found,) = header_of(one_file(file_of(first))).slices
    assert found.stance == stance


@pytest.mark.slow
@pytest.mark.parametrize(("position", "stance"), [("HFS", "supine"), ("", None)])
def test_it_is_proposed_and_kept_with_the_scan(position: str, stance: str | None, torso: Rig, tmp_path: Path) -> None:
    scan = read_scan(image(torso, position=position))
    write_stored(scan, tmp_path / "kept")
    for each in (scan, read_scan(tmp_path / "kept", STORED)):
        frame = prepared_scan(each, "auto").frame
        assert (each.stated_stance, frame.stance) == (stance, stance or "prone")
        said = f"The image's header says that the patient lies {stance}. If that is wrong, state the position."
        assert (frame.stance_reason == said) == (stance is not None)
    said = [note for note in scan.notes if "nipples are looked for in prone images only" in note]
    assert len(said) == (stance == "supine")
    assert stance != "supine" or scan.seen == ()


@pytest.mark.slow
def test_a_fit_in_another_position_says_so(tmp_path: Path) -> None:
    rig = walled_patient(tmp_path)
    given = {"scan": image(rig, position="HFS"), "landmarks": tmp_path / "prone.json"}
    fit = breastrig.fit(
        breastrig.read_scan(given["scan"]), given["landmarks"], stance="prone", drawing=None, refine=False
    )
    assert fit.stance == "prone"
    said = "The image's header says that the patient lies supine; this fit is prone. Check which is true."
    assert said in fit.notes
