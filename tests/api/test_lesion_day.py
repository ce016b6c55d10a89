"""The day of a lesion: seen in an MRI's label map, found standing and lying, moved, reported, shown to a visitor."""

import gzip
import io
import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pypdf
import pytest
from flask.testing import FlaskClient
from helpers.blank_pictures import blank_pictures_in_reports
from helpers.label_maps import front_labels, in_lps, nifti
from helpers.scan_files import ply_text
from helpers.waiting import ended
from helpers.walled_patient import lesion_of, walled_patient

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.core.glb import split_glb
from breastrig.execution.limits import FitLimits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.service.service import Service
from breastrig.storage.storage import Storage

PICKED = ("suprasternal_notch", "mid_sternum", "xiphoid", "nipple_L", "nipple_R", "umbilicus")


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Service, FlaskClient]]:
    service = Service(Storage(tmp_path_factory.mktemp("day")), fits=FitLimits(workers=1, grace_s=0.1))
    with service.started():
        yield service, create_app(Config(), service).test_client()


def places(rig: Rig) -> dict[str, np.ndarray]:
    """(3,) m each."""
    return dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))


def test_a_lesion_of_an_mri_is_seen_on_all_scans_moved_reported_and_shared(
    real: tuple[Service, FlaskClient], monkeypatch: pytest.MonkeyPatch
) -> None:
    service, client = real
    blank_pictures_in_reports(monkeypatch)
    rig = read_rig(default_rig_path())
    marks = places(rig)
    inside = marks["nipple_L"] - [0.012, 0.0, 0.028]
    labels, low, size = front_labels(rig, inside, 7.0)
    lying = rig.template * [1.0, 1.0, 0.95]  # a little flatter
    bodies = {
        "prone": (gzip.compress(nifti(labels, low=low, sizes=np.full(3, size))), "mri.nii.gz", in_lps),
        "standing": (ply_text(1e3 * rig.template, rig.faces), "a.ply", lambda points: 1e3 * points),
        "supine": (ply_text(1e3 * lying, rig.faces), "b.ply", lambda points: 1e3 * points * [1.0, 1.0, 0.95]),
    }
    fits, patient, mri = {}, "", {}
    for stance, (content, name, frame) in bodies.items():
        data = {"file": (io.BytesIO(content), name)} | ({"patient": patient} if patient else {"units": "mm"})
        answer = client.post("/api/scans", data=data | {"units": "mm"})
        assert answer.status_code == 201, answer.json
        scan = answer.json
        patient, mri = scan["patient"], mri or scan
        picked = {name: frame(marks[name]).tolist() for name in PICKED if stance != "prone" or name != "umbilicus"}
        asked = {"scan": scan["id"], "stance": stance, "landmarks": picked}
        fit = client.post("/api/fits", json=asked)
        assert fit.status_code == 202, fit.json
        fits[stance] = fit.json["links"] | {"id": fit.json["id"]}
        row = ended(service, fit.json["id"])
        assert row.state == "done", row.reason

    def seen(stance: str) -> dict:
        (lesion,) = client.get(fits[stance]["plan"]).json["lesions"]
        return lesion

    given = seen("prone")
    assert (given["name"], given["carried"], given["error_mm"]) == ("Lesion 1", False, 0.0)
    assert given["center"] == pytest.approx(in_lps(inside), abs=0.5)
    assert given["radius_mm"] == pytest.approx(7.0, abs=0.3)
    for stance in ("standing", "supine"):
        there = seen(stance)
        true = bodies[stance][2](inside)
        assert there["carried"]
        assert np.linalg.norm(there["center"] - true) < there["error_mm"] < 30.0
        axes = np.array(there["ellipsoid_mm"])
        assert np.square(axes).sum() == pytest.approx(3.0 * there["error_mm"] ** 2, rel=1e-2)
        skin, nipple = there["distances"][:2]
        assert (skin["kind"], nipple["to"], there["seen"]) == ("skin", "nipple_L", True)
        assert nipple["low_mm"] < np.linalg.norm(bodies[stance][2](marks["nipple_L"]) - true) < nipple["high_mm"]
        assert {cut["plane"] for cut in there["slices"] if cut["outlines_mm"]} == {"axial", "sagittal", "coronal"}

    before = seen("standing")
    plan = client.get(mri["links"]["plan"])
    (item,) = plan.json["items"]
    moved = item | {"center": np.add(item["center"], [5.0, 0.0, 0.0]).tolist(), "radiology": "right, 6 o'clock"}  # left
    kept = client.put(mri["links"]["plan"], json={"items": [moved]}, headers={"If-Match": plan.headers["ETag"]})
    assert kept.status_code == 200, kept.json
    went = np.subtract(seen("standing")["center"], before["center"])
    assert went == pytest.approx([5.0, 0.0, 0.0], abs=2.0)
    for stance in ("prone", "standing"):
        there = seen(stance)
        assert re.fullmatch(
            r"left, (\d+(:30| o'clock), \d\d mm from|\d\d mm behind) the nipple", there["clock"]["text"]
        )
        said = "Radiology wrote right; this lesion lies in the left breast."
        assert there["radiology"] == {"agrees": False, "text": said}

    with client.get(f"{fits['standing']['report']}?with={fits['supine']['id']}") as report:
        pages = pypdf.PdfReader(io.BytesIO(report.data)).pages
    text = " ".join(" ".join(page.extract_text() for page in pages).split())
    block = text.split("Lesion: Lesion 1", 1)[1]
    assert re.match(r" standing radius [67][.\d]* mm to the skin \d+ mm, \d+ to \d+ to the nipple, left \d+ mm,", block)
    assert re.search(
        r"± \d+ mm by the clock left, .*Radiology wrote right; .* axial sagittal coronal supine radius", block
    )

    for scan, has_slices in (("none", False), ("plain", True)):
        share = client.post(f"/api/fits/{fits['standing']['id']}/shares", json={"scan": scan}).json
        visitor = client.application.test_client()
        token = share["url"].removeprefix("/s#")
        links = visitor.post("/api/shared/open", json={"token": token}).json["links"]
        with visitor.get(links["plan"]) as plan:
            (shown,) = plan.json["lesions"]
        assert shown["center"] == seen("standing")["center"]
        assert bool(shown["slices"]) == has_slices  # they are cuts of her skin
        with visitor.get(links["fitted_glb"]) as glb:
            (node,) = (each for each in split_glb(glb.data)[0]["nodes"] if each.get("name") == "lesion_Lesion 1")
        assert node["extras"]["error_mm"] == shown["error_mm"]
        assert np.multiply(node["translation"], 1e3) == pytest.approx(shown["center"], abs=1e-2)


def test_a_lesion_near_a_wall_that_the_label_map_names_stays_by_it(
    real: tuple[Service, FlaskClient], tmp_path: Path
) -> None:
    service, client = real
    rig = walled_patient(tmp_path)
    patient, plans = "", {}
    for stance, name in (("prone", "mri.nrrd"), ("standing", "standing.ply")):
        data = {"file": (io.BytesIO((tmp_path / name).read_bytes()), name), "patient": patient}
        scan = client.post("/api/scans", data=data).json
        patient = scan["patient"]
        picked = json.loads((tmp_path / f"{stance}.json").read_text())["landmarks"]
        fit = client.post("/api/fits", json={"scan": scan["id"], "stance": stance, "landmarks": picked}).json
        assert ended(service, fit["id"]).state == "done"
        plans[stance] = client.get(fit["links"]["plan"]).json
    (given,), (there,) = (plans[stance]["lesions"] for stance in ("prone", "standing"))
    assert np.linalg.norm(there["center"] - 1e3 * lesion_of(rig)) < 5.0  # 8.7 without
    seen = {
        stance: [each.get("seen") for each in one["distances"] if each["kind"] == "chest_wall"]
        for stance, one in (("prone", given), ("standing", there))
    }
    assert seen == {"prone": [True], "standing": [None]}
