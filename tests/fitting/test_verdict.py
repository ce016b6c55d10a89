"""A fit's level follows from its signals: several together refuse, one alone never does."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from helpers.toy_rig import toy_rig

from breastrig.fitting.doubt import Doubt
from breastrig.fitting.verdicts.fit_signals import FitSignals
from breastrig.fitting.verdicts.repeated import told_by_a_person
from breastrig.fitting.verdicts.verdict import UNKNOWN_MODEL, Verdict, shows_a_part, verdict, verdict_limits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status

RIGHT = FitSignals(
    clearness=0.15,
    seen=0.78,
    distance_p95=0.002,
    beyond=0.002,
    angle_p90=0.15,
    scan_p95=0.003,
    explained=0.995,
    facing=0.98,
    stretch=0.1,
    limits=0.03,
)
LIMITS = verdict_limits(read_rig(default_rig_path()))
assert LIMITS is not None
NAMES = list(LIMITS.signals)


def beyond_no_torso(*names: str) -> FitSignals:
    """A right fit but for these signals, which are a little beyond their second limit."""
    assert LIMITS is not None
    values = {}
    for name in names:
        limit = LIMITS.signals[name]
        values[name] = limit.no_torso + 0.05 * (limit.no_torso - limit.check)
    return replace(RIGHT, **values)


def test_the_limits_stand_on_the_side_that_they_say() -> None:
    assert LIMITS is not None
    for name, limit in LIMITS.signals.items():
        assert (limit.no_torso > limit.check) == limit.above, name
        value = asdict(RIGHT)[name]
        assert (value < limit.check) == limit.above, name


def test_a_right_fit_is_good_and_has_no_reasons() -> None:
    found = verdict(RIGHT, Status.CONVERGED, LIMITS)
    assert (found.level, found.reasons, found.is_torso) == ("good", (), True)
    placed = verdict(replace(RIGHT, clearness=np.nan), Status.CONVERGED, LIMITS)  # by landmarks
    assert placed.level == "good"


@pytest.mark.parametrize("name", NAMES)
def test_one_signal_alone_is_to_be_checked_and_named(name: str) -> None:
    found = verdict(beyond_no_torso(name), Status.CONVERGED, LIMITS)
    assert (found.level, found.is_torso, len(found.reasons)) == ("check", True, 1)
    assert found.reasons[0].endswith(".")
    assert "{" not in found.reasons[0]


def test_more_and_more_signals_make_it_unusable_and_then_no_torso() -> None:
    assert LIMITS is not None
    levels = [verdict(beyond_no_torso(*NAMES[:count]), Status.CONVERGED, LIMITS) for count in range(len(NAMES) + 1)]
    for count, found in enumerate(levels):
        assert len(found.reasons) == count
        assert (found.level == "unusable") == (count >= LIMITS.unusable_at)
        assert found.is_torso == (count < LIMITS.refused_at)


def test_who_named_landmarks_is_not_told_that_it_is_no_torso() -> None:
    found = verdict(beyond_no_torso(*NAMES), Status.CONVERGED, LIMITS, placed=True)
    assert (found.level, found.is_torso) == ("unusable", True)


def test_the_strongest_reasons_come_first_and_make_one_sentence() -> None:
    far = replace(beyond_no_torso(*NAMES), scan_p95=0.4)
    found = verdict(far, Status.CONVERGED, LIMITS)
    assert "400 mm" in found.reasons[0]
    assert found.refusal("torso").startswith("This does not look like a torso: one in twenty places of the scan")
    assert found.refusal("torso").count(". ") == 0
    assert found.refusal("torso").endswith(".")
    assert len(found.refusal("torso")) < 400


def test_a_fit_that_did_not_come_to_rest_is_to_be_checked() -> None:
    for status in (Status.OUT_OF_ITERATIONS, Status.STALLED):
        found = verdict(RIGHT, status, LIMITS)
        assert found.level == "check"
        assert "did not come to rest" in found.reasons[0]


def test_a_model_that_found_no_skin_at_all_is_refused() -> None:
    nothing = replace(RIGHT, seen=0.0, distance_p95=np.nan, beyond=np.nan, angle_p90=np.nan, scan_p95=np.nan)
    found = verdict(nothing, Status.STALLED, LIMITS)
    assert not found.is_torso
    assert "found no skin" in found.refusal("torso")


def test_of_another_model_nothing_is_known() -> None:
    assert verdict_limits(toy_rig()) is None
    found = verdict(RIGHT, Status.CONVERGED, None)
    assert (found.level, found.reasons, found.is_torso) == ("uncalibrated", (UNKNOWN_MODEL,), True)
    assert "Not calibrated for this rig" in UNKNOWN_MODEL
    assert verdict(RIGHT, Status.STALLED, None).level == "check"
    assert verdict(replace(RIGHT, scan_p95=np.nan), Status.CONVERGED, None).level == "unusable"


def test_landmarks_in_doubt_make_a_right_fit_worth_a_look() -> None:
    def judged(*doubts: Doubt) -> Verdict:
        return verdict(RIGHT, Status.CONVERGED, LIMITS, placed=True, doubts=doubts)

    navel, notch = (
        Doubt(("umbilicus",), "It is far.", followed=True),
        Doubt(("suprasternal_notch",), "It is elsewhere."),
    )
    one, two = judged(navel), judged(navel, notch)
    assert one.level == two.level == "check"
    assert one.reasons == ("One landmark is in doubt; look at what is asked about it.",)
    assert two.reasons == ("2 landmarks are in doubt; look at what is asked about them.",)
    pair = ("nipple_L", "nipple_R")
    exchanged = Doubt(pair, "nipple_L and nipple_R look exchanged; they were not followed.", exchanged=True)
    assert judged(navel, exchanged).reasons == (
        "nipple_L and nipple_R look exchanged; look at what is asked about them.",
        "One landmark is in doubt; look at what is asked about it.",
    )


def test_a_part_of_a_body_is_to_be_checked_unless_landmarks_say_where_it_belongs() -> None:
    part = replace(RIGHT, seen=0.33)
    alone = verdict(part, Status.CONVERGED, LIMITS)
    assert alone.level == "check"
    assert alone.reasons[0].startswith("The scan shows only 33 % of the body")
    assert verdict(replace(part, clearness=np.nan), Status.CONVERGED, LIMITS, placed=True).level == "good"


def test_a_fit_is_as_good_as_the_lines_that_it_places() -> None:
    def judged(error: float | None, agreed: int = 0) -> Verdict:
        return verdict(RIGHT, Status.CONVERGED, LIMITS, line_error=error, agreed=agreed)

    assert judged(None).level == judged(0.009, agreed=3).level == "good"
    far, unknown = judged(0.0146, agreed=12), judged(0.3)
    assert (far.level, unknown.level) == ("check", "unusable")
    assert unknown.is_torso
    assert far.reasons == (
        "Lines on the breasts may be 15 mm off; place landmarks by hand, or plan with that margin.",
        "12 landmarks were only agreed to where they were proposed; they keep the proposals' errors.",
    )
    assert unknown.reasons == ("Where lines on the breasts lie is not known; place at least three landmarks by hand.",)


def test_picks_where_they_were_proposed_tell_nothing() -> None:
    proposed = {"xiphoid": np.zeros(3), "umbilicus": np.array([0.0, -0.15, 0.0])}
    picks = {
        "xiphoid": np.array([0.001, 0.0, 0.0]),
        "umbilicus": np.array([0.003, -0.15, 0.0]),
        "nipple_L": np.array([0.1, 0.0, 0.0]),
    }
    assert told_by_a_person(picks, proposed) == {"umbilicus", "nipple_L"}


def test_repeated_proposals_do_not_place_a_part() -> None:
    part = replace(RIGHT, seen=0.57)
    assert shows_a_part(part, LIMITS)
    assert not shows_a_part(RIGHT, LIMITS)
    assert verdict(part, Status.CONVERGED, LIMITS, placed=True).level == "good"
    assert verdict(part, Status.CONVERGED, LIMITS, placed=True, repeated=True).level == "check"
    assert verdict(RIGHT, Status.CONVERGED, LIMITS, placed=True, repeated=True).level == "good"
