"""A proposal's error is that of the fit behind it: it holds the true place, on half a torso too."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.core.assets import asset_folder
from breastrig.fitting import posterior
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.hypotheses import scan_orientation
from breastrig.fitting.observed.landmarks import colour_observations, with_observations
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.propose import Proposal, confidence_of, expected_error
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.uncertainty.radii import HOLDS_90, radii
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.clean import clean, compact
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from breastrig.use.landmarks import propose_on_scan

pytestmark = pytest.mark.long

STANDING = asset_folder("example") / "standing"
HOLLOWS = {  # of the standing example
    "umbilicus": "dent seen",
    "suprasternal_notch": "hollow seen",
    "inframammary_fold_L": "fold seen",
    "inframammary_fold_R": "fold seen",
    "acromion_L": "shoulder's edge seen",
    "acromion_R": "shoulder's edge seen",
}


def gaps_in_errors(proposals: dict[str, Proposal]) -> np.ndarray:
    """(L,) distance of the proposal from each true place, in units of its error."""
    true, unit = read_landmarks(STANDING / "landmarks.json")
    per_unit = {"mm": 1e-3, "m": 1.0}[str(unit)]
    assert all(each.error is not None for each in proposals.values())
    errors = [proposals[name].error for name in true]
    gaps = [np.linalg.norm(proposals[name].point - per_unit * place) for name, place in true.items()]
    return np.array(gaps) / np.array(errors, dtype=np.float64)


@pytest.mark.slow
@pytest.mark.parametrize("side", [1.0])
def test_on_half_a_torso_the_errors_say_that_the_body_may_lie_another_way(side: float) -> None:
    scan = read_scan(STANDING / "scan.ply", "ply", "auto", texture=False)
    true, unit = read_landmarks(STANDING / "landmarks.json")
    per_unit = {"mm": 1e-3, "m": 1.0}[str(unit)] / scan.metres_per_unit
    left = per_unit * (true["acromion_L"] - true["acromion_R"])
    middle = per_unit * 0.5 * (true["acromion_L"] + true["acromion_R"])
    kept = (side * ((scan.vertices - middle) @ left) > 0.0)[scan.faces].all(axis=1)
    vertices, faces = compact(scan.vertices, scan.faces[kept])
    half = replace(scan, vertices=vertices, faces=faces)
    proposals = propose_on_scan(read_rig(default_rig_path()), half)
    assert (gaps_in_errors(proposals) <= 1.0).mean() >= 0.8


def test_a_confidence_is_that_of_its_error() -> None:
    proposals = propose_on_scan(
        read_rig(default_rig_path()), read_scan(STANDING / "scan.ply", "ply", "auto", texture=False)
    )
    for each in proposals.values():
        assert each.confidence == round(confidence_of(each.error / HOLDS_90), 2)
        if each.reason is None:
            assert 0.01 < each.error < 0.08
        elif each.reason == "areola seen":
            assert 0.003 < each.error < 0.013
        else:
            assert each.reason in HOLLOWS.values()
            assert 0.008 < each.error < 0.05
    for error in (0.005, 0.01, 0.04):
        assert expected_error(confidence_of(error)) == pytest.approx(error)


@pytest.mark.slow
def test_areolae_that_the_scan_shows_place_the_nipples_and_without_colour_the_form_does() -> None:
    rig, place = read_rig(default_rig_path()), STANDING.parent / "supine"
    scan = read_scan(place / "scan.ply", "ply", "auto")
    true, unit = read_landmarks(place / "landmarks.json")
    per_unit = {"mm": 1e-3, "m": 1.0}[str(unit)]
    coloured, plain = propose_on_scan(rig, scan), propose_on_scan(rig, replace(scan, colours=None))
    for name in ("nipple_L", "nipple_R"):
        off, form = (np.linalg.norm(each[name].point - per_unit * true[name]) for each in (coloured, plain))
        assert off < 0.004
        assert form > 1.4 * off  # what the form alone can say
        assert plain[name].reason is None
    by_form = {*HOLLOWS.values()}
    by_colour = {name for name, each in coloured.items() if each.reason and each.reason not in by_form}
    assert by_colour == {"nipple_L", "nipple_R"}


def test_a_scan_without_colour_is_not_looked_at_for_any(monkeypatch: pytest.MonkeyPatch) -> None:
    import breastrig.colour.features.observe as observe

    def never(*_: object) -> None:
        raise AssertionError("there is no colour to look at")

    monkeypatch.setattr(observe, "observed_landmarks", never)
    scan = replace(read_scan(STANDING / "scan.ply", "ply", "auto"), colours=None)
    found = propose_on_scan(read_rig(default_rig_path()), scan)
    assert {name: each.reason for name, each in found.items() if each.reason is not None} == HOLLOWS


@pytest.mark.slow
def test_areolae_where_the_form_has_them_confirm_how_the_body_lies() -> None:
    """An unclear start makes all radii large, for the body may lie the other way; its back has no areolae."""
    rig = read_rig(default_rig_path())
    scan = read_scan(STANDING / "scan.ply", "ply", "auto")
    orientation, task, begun = scan_orientation(rig, prepared(clean(scan), "auto"), load_recipe("default"))
    *_, last = begun or fit_iterates(task)
    shown = colour_observations(task, last.parameters, orientation.margin, scan)
    assert set(shown) == {"nipple_L", "nipple_R"}
    unclear = 0.0
    form = radii(Posterior(task, last.parameters), unclear)
    coloured = radii(Posterior(with_observations(task, shown, last.parameters), last.parameters), unclear)
    one = radii(
        Posterior(with_observations(task, {"nipple_L": shown["nipple_L"]}, last.parameters), last.parameters), unclear
    )
    assert form.landmarks["xiphoid"] > 0.3
    assert one.landmarks["xiphoid"] > 0.3  # a single one may be anything
    assert coloured.landmarks["xiphoid"] < 0.05


def test_only_what_the_form_shows_is_on_the_scan_for_being_near_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside a scan's border there is skin near, but not that of the landmark."""
    monkeypatch.setattr(posterior, "to_skin", lambda *_: 0.0)
    scan = read_scan(STANDING / "scan.ply", "ply", "auto", texture=False)
    left = (scan.vertices[:, 0] > np.median(scan.vertices[:, 0]))[np.asarray(scan.faces)].all(axis=1)
    half = replace(scan, faces=np.asarray(scan.faces)[left])
    found = propose_on_scan(read_rig(default_rig_path()), half)
    assert not any(each.on_scan for name, each in found.items() if name in ("nipple_R", "midclavicle_R"))
    assert found["nipple_L"].on_scan
