"""The day of a lesion by the chest wall: seen in an MRI, found standing, moved, reported, shown to a visitor."""

import io
import json
import re
from pathlib import Path

import numpy as np
import pypdf
import pytest
from helpers.blank_pictures import any_reports_of_links, blank_pictures_in_reports
from helpers.label_maps import in_lps
from helpers.waiting import ended
from helpers.walled_patient import RADIUS, lesion_of, marks, walled_patient

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.core.glb import split_glb
from breastrig.execution.limits import FitLimits
from breastrig.service.service import Service
from breastrig.storage.storage import Storage


def test_a_lesion_of_an_mri_is_seen_on_another_scan_moved_reported_and_shared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blank_pictures_in_reports(monkeypatch)
    any_reports_of_links(monkeypatch)
    rig = walled_patient(tmp_path)
    inside, nipple = lesion_of(rig), marks(rig, rig.template)["nipple_L"]
    service = Service(Storage(tmp_path / "data"), fits=FitLimits(workers=1, grace_s=0.1))
    with service.started():
        client = create_app(Config(), service).test_client()
        fits, patient, mri = {}, "", {}
        for stance, name in (("prone", "mri.nrrd"), ("standing", "standing.ply")):
            data = {"file": (io.BytesIO((tmp_path / name).read_bytes()), name), "patient": patient}
            answer = client.post("/api/scans", data=data)
            assert answer.status_code == 201, answer.json
            patient, mri = answer.json["patient"], mri or answer.json
            picked = json.loads((tmp_path / f"{stance}.json").read_text())["landmarks"]
            asked = {"scan": answer.json["id"], "stance": stance, "landmarks": picked}
            fit = client.post("/api/fits", json=asked)
            assert fit.status_code == 202, fit.json
            fits[stance] = fit.json["links"] | {"id": fit.json["id"]}
            row = ended(service, fit.json["id"])
            assert row.state == "done", row.reason

        def seen(stance: str) -> dict:
            (lesion,) = client.get(fits[stance]["plan"]).json["lesions"]
            return lesion

        given, there = seen("prone"), seen("standing")
        assert (given["name"], given["carried"], given["error_mm"]) == ("Lesion 1", False, 0.0)
        assert given["center"] == pytest.approx(in_lps(inside), abs=0.5)
        assert given["radius_mm"] == pytest.approx(RADIUS, abs=0.3)
        assert there["carried"]
        assert np.linalg.norm(there["center"] - 1e3 * inside) < min(there["error_mm"], 5.0)  # 8.7 without the wall
        axes = np.array(there["ellipsoid_mm"])
        assert np.square(axes).sum() == pytest.approx(3.0 * there["error_mm"] ** 2, rel=1e-2)
        skin, to_nipple = there["distances"][:2]
        assert (skin["kind"], to_nipple["to"], there["seen"]) == ("skin", "nipple_L", True)
        assert to_nipple["low_mm"] < 1e3 * np.linalg.norm(nipple - inside) < to_nipple["high_mm"]
        assert {cut["plane"] for cut in there["slices"] if cut["outlines_mm"]} == {"axial", "sagittal", "coronal"}
        walls = [
            [each.get("seen") for each in one["distances"] if each["kind"] == "chest_wall"] for one in (given, there)
        ]
        assert walls == [[True], [None]]

        plan = client.get(mri["links"]["plan"])
        (item,) = plan.json["items"]
        left = np.add(item["center"], [5.0, 0.0, 0.0]).tolist()
        moved = item | {"center": left, "radiology": "right, 6 o'clock"}
        kept = client.put(mri["links"]["plan"], json={"items": [moved]}, headers={"If-Match": plan.headers["ETag"]})
        assert kept.status_code == 200, kept.json
        after = {stance: seen(stance) for stance in fits}
        assert np.subtract(after["standing"]["center"], there["center"]) == pytest.approx([5.0, 0.0, 0.0], abs=2.0)
        for shown in after.values():
            assert re.fullmatch(
                r"left, (\d+(:30| o'clock), \d\d mm from|\d+ mm behind) the nipple", shown["clock"]["text"]
            )
            said = "Radiology wrote right; this lesion lies in the left breast."
            assert shown["radiology"] == {"agrees": False, "text": said}

        with client.get(f"{fits['standing']['report']}?with={fits['prone']['id']}") as report:
            pages = pypdf.PdfReader(io.BytesIO(report.data)).pages
        text = " ".join(" ".join(page.extract_text() for page in pages).split())
        block = text.split("Lesion: Lesion 1", 1)[1]
        assert re.match(
            r" standing radius [56][.\d]* mm to the skin \d+ mm, \d+ to \d+ to the nipple, left \d+ mm,", block
        )
        assert re.search(
            r"± \d+ mm by the clock left, .*Radiology wrote right; .* axial sagittal coronal prone radius", block
        )

        for scan, has_slices in (("none", False), ("plain", True)):
            share = client.post(f"/api/fits/{fits['standing']['id']}/shares", json={"scan": scan}).json
            visitor = client.application.test_client()
            token = share["url"].removeprefix("/s#")
            links = visitor.post("/api/shared/open", json={"token": token}).json["links"]
            with visitor.get(links["plan"]) as plan:
                (shown,) = plan.json["lesions"]
            assert shown["center"] == after["standing"]["center"]
            assert bool(shown["slices"]) == has_slices  # they are cuts of her skin
            with visitor.get(links["fitted_glb"]) as glb:
                (node,) = (each for each in split_glb(glb.data)[0]["nodes"] if each.get("name") == "lesion_Lesion 1")
            assert node["extras"]["error_mm"] == shown["error_mm"]
            assert np.multiply(node["translation"], 1e3) == pytest.approx(shown["center"], abs=1e-2)
