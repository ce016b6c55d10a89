"""A fit as DICOM objects: read back by libraries of others, and what is said of codes, names and numbers."""

import io
import json
import struct
from datetime import date
from pathlib import Path

import gdcm
import highdicom
import numpy as np
import pydicom
import pypdf
import pytest
import trimesh
from helpers.blank_pictures import coarse_pictures
from helpers.written_fit import write_fit
from pydicom.dataset import Dataset

import breastrig
from breastrig.archive.identities import patient_of
from breastrig.archive.patient_frame import to_patient
from breastrig.cli.main import main
from breastrig.core.errors import BadInput
from breastrig.rig.model import Rig
from breastrig.scan.volumes.label_map import FRAME
from breastrig.use.archive import objects
from breastrig.use.folder.fit_folder import read_fit_folder
from breastrig.use.reports.report import stance_of

CODE = "K7M-4QX"
TURN = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # the scanner's frame: no axis of the body's
CSV = f"code,id,name,birth_date,sex,accession\n{CODE},4711,Müller^Jürgen=山田^花子=やまだ^はなこ,1970-12-31,F,A-17\n"
NAMES = ("report", "measures", "skin", "scan")


def fit_of(folder: Path, rig: Rig, **more: object) -> Path:
    patient = {"code": CODE, "given": True, "scanned": "2026-11-25"}
    moved = np.array(rig.template) @ TURN.T + [0.3, -0.2, 5.0]
    return write_fit(folder, rig, moved, np.full(len(moved), 0.002), patient=patient, **more)


@pytest.fixture(scope="module")
def fit(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fit_of(tmp_path_factory.mktemp("fit") / "fit", rig)


@pytest.fixture(scope="module")
def written(fit: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("dicom")
    (out / "ids.csv").write_text(CSV, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        coarse_pictures(patch)
        breastrig.write_dicom(fit, out / "named", identities=out / "ids.csv")
        breastrig.write_dicom(fit, out / "again", identities=out / "ids.csv")
        assert main(["dicom", str(fit), "-o", str(out / "coded")]) == 0
    return out


def read(folder: Path) -> dict[str, Dataset]:
    return {name: pydicom.dcmread(folder / f"{name}.dcm") for name in NAMES}


def surface_in(found: Dataset) -> trimesh.Trimesh:
    content = found.EncapsulatedDocument[: found.EncapsulatedDocumentLength]
    assert len(content) == 84 + 50 * struct.unpack("<I", content[80:84])[0]
    return trimesh.load(io.BytesIO(content), file_type="stl", process=False)


def test_gdcm_reads_one_study_of_one_patient_whose_series_say_research_use(written: Path) -> None:
    studies = set()
    for name in NAMES:
        reader = gdcm.Reader()
        reader.SetFileName(str(written / "named" / f"{name}.dcm"))
        assert reader.Read()
        text = gdcm.StringFilter()
        text.SetFile(reader.GetFile())
        said = [
            text.ToString(gdcm.Tag(*tag))
            for tag in ((0x10, 0x20), (0x20, 0xD), (0x8, 0x103E), (0x8, 0x5), (0x10, 0x10))
        ]
        studies.add((said[0], said[1], said[3].strip(), said[4].strip()))
        assert said[2].strip() == f"BreastRig {name}, standing (research use only)"
    assert len(studies) == 1
    patient, _, characters, person = studies.pop()
    assert (patient, characters) == ("4711", "ISO_IR 192")
    assert person == "Müller^Jürgen=山田^花子=やまだ^はなこ"


def test_the_surfaces_are_true_in_mm_to_the_left_back_and_head(written: Path, rig: Rig) -> None:
    found = read(written / "named")
    skin = surface_in(found["skin"])
    corners = 1e3 * rig.template[rig.faces]
    left, up, front = corners[..., 0], corners[..., 1], corners[..., 2]
    true = np.stack([left, -front, up], axis=-1)
    made = skin.triangles
    offset = (true - made).reshape(-1, 3)
    assert np.ptp(offset, axis=0).max() < 0.01  # turned, never mirrored or scaled
    assert found["skin"].FrameOfReferenceUID == found["scan"].FrameOfReferenceUID
    assert np.allclose(surface_in(found["scan"]).triangles, made, atol=0.01)


def test_the_pdf_is_the_report_and_carries_the_code_alone(written: Path) -> None:
    found = read(written / "named")["report"]
    assert found.MIMETypeOfEncapsulatedDocument == "application/pdf"
    text = "".join(page.extract_text() for page in pypdf.PdfReader(io.BytesIO(found.EncapsulatedDocument)).pages)
    assert CODE in text
    assert "4711" not in text
    assert "ller" not in text.replace("taller", "")


def test_highdicom_reads_the_measures_with_units_sides_and_bands(written: Path, fit: Path, tmp_path: Path) -> None:
    report = highdicom.sr.srread(written / "named" / "measures.dcm")
    assert report.ContentTemplateSequence[0].TemplateIdentifier == "1500"
    groups = {str(g.tracking_identifier): g for g in report.content.get_image_measurement_groups()}
    assert set(groups) == {"left breast", "right breast", "both breasts"}
    row = next(each for each in breastrig.measure(fit) if (each.name, each.kind) == ("notch_nipple", "straight"))
    found = [m for m in groups["left breast"].get_measurements() if m.name.value == "notch_nipple"]
    straight = next(m for m in found if m.method.value == "straight_90")
    assert (straight.value, straight.unit.value) == (pytest.approx(row.left.value, abs=0.006), "mm")
    volume = next(m for m in groups["right breast"].get_measurements() if m.name.value == "118565006")
    assert (volume.name.scheme_designator, volume.unit.value) == ("SCT", "cm3")
    assert volume.value == pytest.approx(
        next(m for m in breastrig.measure(fit) if m.name == "volume").right.value, abs=0.06
    )
    bands = [e for e in report.iterall() if e.keyword == "CodeMeaning" and "measurement uncertainty" in str(e.value)]
    assert len(bands) > 20
    assert report.CodingSchemeIdentificationSequence[0].CodingSchemeDesignator == "99BREASTRIG"


def test_nothing_of_the_content_changes_when_it_is_made_again(written: Path) -> None:
    for name in NAMES:
        assert (written / "named" / f"{name}.dcm").read_bytes() == (written / "again" / f"{name}.dcm").read_bytes()
    named, coded = read(written / "named"), read(written / "coded")
    assert not {each.SOPInstanceUID for each in named.values()} & {each.SOPInstanceUID for each in coded.values()}
    assert named["scan"].StudyInstanceUID != coded["scan"].StudyInstanceUID  # one study is never two patients'
    kept = json.loads((written / "named" / "dicom.json").read_text())
    assert kept["objects"] == {name: named[name].SOPInstanceUID for name in NAMES}
    assert "4711" not in (written / "named" / "dicom.json").read_text()


def test_without_a_file_the_code_is_the_patients_id_and_the_object_says_so(written: Path) -> None:
    for found in read(written / "coded").values():
        assert (found.PatientID, str(found.PatientName), found.PatientBirthDate) == (CODE, f"{CODE}^", "")
        assert found.PatientIdentityRemoved == "YES"
        assert found.StudyDate == "20261125"
    assert "PatientIdentityRemoved" not in read(written / "named")["scan"]


def test_values_have_the_lengths_that_their_representations_allow(written: Path) -> None:
    for folder in ("named", "coded"):
        for found in read(written / folder).values():
            for element in found.iterall():
                if element.VR not in ("SQ", "OB") and element.value not in (None, ""):
                    for value in element.value if element.VM > 1 else [element.value]:
                        pydicom.valuerep.validate_value(
                            element.VR, value if element.VR in ("FD", "US", "UL") else str(value), pydicom.config.RAISE
                        )


def test_a_scan_of_an_image_stays_in_its_frame(rig: Rig, tmp_path: Path) -> None:
    of_image = read_fit_folder(fit_of(tmp_path / "image", rig, notes=[FRAME]), None)
    assert np.array_equal(to_patient(stance_of(of_image), of_image.result), np.eye(4))


def test_a_prediction_has_no_scan_and_says_so(rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(objects, "pdf_of", lambda *_: b"%PDF")
    breastrig.write_dicom(fit_of(tmp_path / "fit", rig, predicted=True), tmp_path / "out")
    assert not (tmp_path / "out" / "scan.dcm").exists()
    found = pydicom.dcmread(tmp_path / "out" / "skin.dcm")
    assert found.SeriesDescription == "BreastRig skin, standing, predicted (research use only)"


def test_a_fit_that_cannot_be_used_is_refused(rig: Rig, tmp_path: Path) -> None:
    bad = fit_of(tmp_path / "bad", rig, verdict={"level": "unusable", "reasons": ["Far off."]})
    with pytest.raises(BadInput, match=r"^This fit cannot be used: Far off. No DICOM object is made of it.$"):
        breastrig.write_dicom(bad, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.csv", "code,id\nOTHER,1\n", f"does not name the code {CODE}"),
        ("a.csv", f"code,id\n{CODE},1\n{CODE},2\n", "names the code K7M-4QX 2 times"),
        ("a.csv", "number,person\n1,2\n", "no columns code and id"),
        ("a.csv", f"code,id\n{CODE},\n", "there is no id"),
        ("a.csv", f"code,id,birth_date\n{CODE},secret,31.12.1970\n", "Line 2 .*birth_date .*YYYY-MM-DD"),
        ("a.csv", f"code,id,sex\n{CODE},secret,W\n", "sex .*F, M or O"),
        ("a.csv", f"code,id\n{CODE},secret{'x' * 64}\n", "id .*at most 64 characters"),
        ("a.csv", f"code,id,accession\n{CODE},1,secret12345678901234\n", "accession .*at most 16"),
        ("a.csv", f"code,id\n{CODE},Müller\n".encode("latin-1"), "neither CSV nor TOML in UTF-8"),
        ("a.toml", "= secret", "neither CSV nor TOML"),
        ("b.csv", None, "cannot be read"),
    ],
)
def test_a_wrong_file_of_identities_is_refused_without_a_word_of_its_contents(
    name: str, content: str | bytes | None, said: str, tmp_path: Path
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(BadInput, match=said) as error:
        patient_of(CODE, tmp_path / name)
    assert "secret" not in str(error.value)
    assert "ller" not in str(error.value)


def test_identities_may_be_a_table_of_excel_or_toml(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(f"\ufeffcode;id;name\r\n{CODE};1;Groß^Eva\r\n".encode())
    assert patient_of(CODE, tmp_path / "a.csv").name == "Groß^Eva"
    (tmp_path / "a.toml").write_text(f'["{CODE}"]\nid = "1"\nbirth_date = {date(1970, 12, 31)}\n')
    assert patient_of(CODE, tmp_path / "a.toml").birth_date == "1970-12-31"
