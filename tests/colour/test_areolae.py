"""Areolae from the colours of a fitted scan to the table of measures."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.painted_body import PaintedBody, painted_body
from helpers.results import result_document, result_file

import breastrig
from breastrig.colour.areolae import ObservedAreola, areolae_document, areolae_of
from breastrig.core.errors import BadInput
from breastrig.files.result import parsed_result
from breastrig_studies.virtual.painted.files import scan_zip

pytestmark = pytest.mark.long


def disc(radius: float) -> np.ndarray:
    turn = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    return radius * np.stack([np.cos(turn), np.sin(turn), np.zeros(40)], axis=1)


def test_result_json_keeps_areolae_in_the_scans_unit_and_says_what_was_not_seen() -> None:
    found = {"L": ObservedAreola(0.036, 0.002, disc(0.018)), "R": None}
    document = areolae_document(found, 1e-3)
    assert document["R"] is None
    assert document["L"].diameter_mm == 36.0
    assert document["L"].rim[0] == pytest.approx([18.0, 0.0, 0.0])
    read = areolae_of(result_file(areolae=document), 1e-3)
    assert read["R"] is None
    assert (read["L"].diameter, read["L"].half) == pytest.approx((0.036, 0.002))
    np.testing.assert_allclose(read["L"].rim, found["L"].rim, atol=1e-9)
    assert areolae_of(result_file(), 1.0) == {}


ENTRY = {"diameter_mm": 36.0, "within_mm": 2.0, "rim": disc(0.018).tolist()}


@pytest.mark.parametrize(
    "damage", [{"diameter_mm": -1.0}, {"diameter_mm": "wide"}, {"rim": [[0.0, 0.0]]}, {"within_mm": None}]
)
def test_damaged_areolae_are_refused_with_a_sentence(damage: dict[str, Any]) -> None:
    with pytest.raises(BadInput, match=r"fit/result\.json is damaged or of another version \(areolae\.L\."):
        parsed_result(json.dumps(result_document(areolae={"L": ENTRY | damage})).encode(), "fit")


def uncertain(fit: breastrig.Fit) -> dict[str, float]:
    return dict(fit.result["landmark_uncertainty_mm"])


@pytest.fixture(scope="module")
def half_covered() -> PaintedBody:
    return painted_body(tone=4, states=(("R", "covered"),), side=640)


def test_a_textured_scan_has_the_diameter_of_the_areola_that_is_seen(half_covered: PaintedBody, tmp_path: Path) -> None:
    woman, place = half_covered, tmp_path / "scan.zip"
    scan = woman.scan
    place.write_bytes(scan_zip(scan.vertices, scan.faces, woman.picture.atlas, woman.picture.picture.jpeg, 6))
    fit = breastrig.fit(place, units="m", drawing=None, refine=False)
    assert set(fit.result["areolae"]) == {"L", "R"}
    assert fit.result["areolae"]["R"] is None
    assert "Found by colour: nipple_L, umbilicus (areola seen, navel seen)." in fit.notes
    assert fit.seen == {"nipple_L": "areola seen", "umbilicus": "navel seen"}
    for name in fit.seen:  # as it is seen and with its own error, wherever the model ends
        off, radius = np.linalg.norm(fit.landmarks[name] - woman.body.landmarks[name]), 1e-3 * uncertain(fit)[name]
        assert off < min(radius, 0.006)
        assert radius < 0.01
    model = dict(
        zip(fit.model.landmark_names, fit.model.landmark_points().positions(fit.vertices, fit.faces), strict=True)
    )
    for name in fit.model.landmark_names:
        assert np.allclose(fit.landmarks[name], model[name], atol=2e-6) is (name not in fit.seen)
    measured = breastrig.measure(fit)
    between = {name for each in measured if each.name == "notch_nipple" for name in each.landmarks}
    assert between == {"nipple_L (seen)", "nipple_R (model)", "suprasternal_notch (model)"}
    fit.save(tmp_path / "saved")
    loaded = breastrig.Fit.load(tmp_path / "saved")
    assert loaded.seen == fit.seen
    np.testing.assert_array_equal(loaded.in_metres.seen["umbilicus"], fit.landmarks["umbilicus"])
    (row,) = (each for each in measured if each.name == "areola_diameter")
    assert row.right is None
    assert "the right one is not seen" in row.method
    rim = woman.rims["L"] - woman.rims["L"].mean(axis=0)
    true = 2e3 * np.sqrt(0.5 * np.linalg.norm(np.cross(rim, np.roll(rim, -1, axis=0)), axis=1).sum() / np.pi)
    assert row.left.value == pytest.approx(true, abs=4.0)
    assert row.left.low < row.left.value
