"""What is judged is what was found: radii with the start's clearness, lines with their error, breasts' own signals.

A note says what is to be known, a check what is to be looked at.
"""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.forearm import forearm_rig, posed_forearm

from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.line_error import ACROSS
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.task import PickIssue
from breastrig.fitting.uncertainty.radii import HOLDS_90, radii
from breastrig.fitting.verdicts import verdict as judge_module
from breastrig.fitting.verdicts import verdict as verdict_module
from breastrig.fitting.verdicts.fit_signals import FitSignals
from breastrig.fitting.verdicts.reasons import GivenLandmarks, of_doubts
from breastrig.fitting.verdicts.verdict import Verdict, judge, unusual_size, verdict, verdict_limits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status
from breastrig.rig.model import Rig
from breastrig.scan.unscaled import unscaled

NONE = GivenLandmarks(picked=0, left=0, followed=0)
FACTORS = {state: {"other": times} for state, times in (("seen_alone", 0.5), ("hidden_alone", 9.0), ("alone", 3.0))}
SCATTER = """
expected_scatter = 1.0
freedom_given = 4.0
freedom_elsewhere = 16.0
[without_picks]
clear = 0.2
unclear = 0.1
astray = 0.02
"""


@pytest.fixture(scope="module")
def alone(torso: Rig) -> Posterior:
    """A forearm of which as much is known as of the torso, fitted without landmarks."""
    known = {
        "radii.json": json.dumps({"stances": {"standing": FACTORS}}),
        "uncertainty.toml": SCATTER,
        "verdict.toml": torso.known["verdict.toml"],
    }
    rig = replace(forearm_rig(), known=known)
    skin, _ = posed_forearm(rig)
    places = dict(zip(rig.landmark_names, rig.landmark_points().positions(skin, rig.faces), strict=True))
    recipe = load_recipe("default").model_copy(update={"body": None})
    task = FitTask(rig, ScanTarget(skin, rig.faces), start_from_landmarks(rig, places), recipe, {})
    return Posterior(task, list(fit_iterates(task))[-1].parameters)


@pytest.mark.parametrize("clearness", [0.3, 0.14, 0.0])
def test_an_unclear_start_makes_the_lines_less_sure_and_the_verdict_says_how_far(
    alone: Posterior, clearness: float
) -> None:
    found, wanted = judge(alone, Status.CONVERGED, NONE, clearness=clearness), radii(alone, clearness)
    assert found.radii.lines == wanted.lines
    assert found.radii.landmarks == wanted.landmarks
    limits = verdict_limits(alone.task.rig)
    far = "Lines may be far off; "
    assert any(reason.startswith(far) for reason in found.verdict.reasons) == (wanted.lines > limits.lines.check)
    assert (wanted.lines > limits.lines.check) == (clearness < 0.2)


def test_an_unknown_size_is_in_every_error_and_the_verdict_notes_it(alone: Posterior) -> None:
    known, unknown = (judge(alone, Status.CONVERGED, NONE, clearness=0.3, size_known=each) for each in (None, False))
    at, deviation = alone.state.vertices, unscaled().deviation
    away = at - at[known.radii.seen].mean(axis=0)
    share = HOLDS_90 * deviation * np.linalg.norm(away, axis=1)
    np.testing.assert_allclose(unknown.radii.vertices, np.hypot(known.radii.vertices, share))
    rig = alone.task.rig
    points = rig.landmark_points().positions(away, rig.faces).ravel()
    np.testing.assert_allclose(unknown.radii.joint, known.radii.joint + deviation**2 * np.outer(points, points))
    assert unknown.radii.lines > known.radii.lines
    said = "The size of this scan is not known, and all errors allow for 4 % of it; "
    assert [each.startswith(said) for each in unknown.verdict.reasons].count(True) == 1
    assert unknown.verdict.about.count("size") == 1
    assert unknown.verdict.reasons[unknown.verdict.about.index("size")].startswith(said)
    assert known.verdict.reasons == tuple(each for each in unknown.verdict.reasons if not each.startswith(said))
    assert known.verdict.level == unknown.verdict.level


def test_the_breasts_are_judged_by_their_own_signals(alone: Posterior, monkeypatch: pytest.MonkeyPatch) -> None:
    real = judge_module.fit_signals

    def signals(*given: Any) -> Any:
        found = real(*given)
        return replace(found, stretch=9.0, limits=1.0, angle_p90=3.0, beyond=1.0) if len(given) == 4 else found

    monkeypatch.setattr(judge_module, "fit_signals", signals)
    found = judge(alone, Status.CONVERGED, NONE, clearness=0.3).verdict
    assert found.is_torso
    assert found.level == "check"
    assert any(reason.startswith("With what is far from the breasts: ") for reason in found.reasons)


@pytest.mark.parametrize("larger", [1.2, 0.8])
@pytest.mark.parametrize(("deviations", "level"), [(1.9, None), (2.5, "good"), (2.99, "good"), (3.01, "check")])
def test_an_unusual_size_is_a_note_and_an_unlikely_one_is_to_be_checked(
    larger: float, deviations: float, level: str | None, torso: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    limits = verdict_limits(torso)
    assert (limits.size.asked, limits.size.unlikely) == (2.0, 3.0)
    sign = 1.0 if larger > 1.0 else -1.0
    monkeypatch.setattr(verdict_module, "times_larger", lambda *_: (larger, sign * deviations))
    target: Any = None
    asked = unusual_size(limits, torso, torso.template, target, "standing")
    assert [reason.note for reason in asked] == ([] if level is None else [level == "good"])
    if level is not None:
        assert f"20 % {'larger' if larger > 1.0 else 'smaller'} than" in asked[0].fact


def said(**changes: Any) -> Verdict:
    """Of a fit without fault, whose twelve landmarks were picked."""
    limits = verdict_limits(read_rig(default_rig_path()))
    assert limits is not None
    right = FitSignals(
        clearness=np.nan, seen=0.8, distance_p95=0.002, beyond=0.002, angle_p90=0.15, explained=0.99, facing=0.98,
        stretch=0.1, limits=0.03,
    )  # fmt: skip
    asked = changes.pop("asked", ())
    error = changes.pop("error", None)
    given = GivenLandmarks(picked=12, left=0, followed=12)
    return verdict(replace(right, **changes), Status.CONVERGED, limits, given, asked, error)


def test_notes_stand_behind_what_is_to_be_checked_and_make_no_fit_worth_a_check() -> None:
    near, far = PickIssue(("nipple_L",), "", followed=True), PickIssue(("acromion_L",), "", followed=True)
    exchanged = PickIssue(("acromion_L", "acromion_R"), "", exchanged=True)
    for doubts, note in (([near], False), ([far], True), ([near, far], False), ([exchanged], False)):
        (reason,) = of_doubts(doubts, {"acromion_L", "acromion_R"})
        assert reason.note == note
        assert said(asked=(reason,)).level == ("good" if note else "check")
    (note,) = of_doubts([far], {"acromion_L"})
    both = said(distance_p95=0.0075, error=0.02, asked=(note,))
    assert both.level == "check"
    assert [reason.split(" ")[0] for reason in both.reasons] == ["Lines", "One", "One"]
    noted = said(distance_p95=0.0075, asked=(note,))
    assert noted.level == "good"
    assert len(noted.reasons) == 2
    some = {"distance_p95": 0.0075, "stretch": 9.0, "limits": 1.0}
    assert said(**some).level == "good"  # twelve landmarks vouch for it
    more = said(**some, angle_p90=3.0)
    assert more.level == "check"
    assert len(more.reasons) == 4


def test_no_place_is_known_where_lines_may_be_a_breasts_radius_off() -> None:
    limits = verdict_limits(read_rig(default_rig_path()))
    assert limits.lines.check == limits.lines.placed < limits.lines.unknown == pytest.approx(ACROSS * 0.06, abs=1e-3)
    assert said(error=0.999 * limits.lines.placed).level == "good"
    assert said(error=1.001 * limits.lines.placed).level == "check"
    assert said(error=0.999 * limits.lines.unknown).level == "check"
    assert said(error=1.001 * limits.lines.unknown).level == "unusable"
