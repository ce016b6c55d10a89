"""A fit's level follows from its signals: several together refuse, one alone never does."""

from collections.abc import Iterator
from dataclasses import asdict, replace
from itertools import product

import numpy as np
import pytest
from helpers.toy_rig import toy_rig

from breastrig.fitting.task import PickIssue
from breastrig.fitting.verdicts.fit_signals import FitSignals
from breastrig.fitting.verdicts.reasons import GivenLandmarks, Reason, of_agreed, of_doubts, picked_names
from breastrig.fitting.verdicts.verdict import Verdict, shows_a_part, verdict, verdict_limits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status
from breastrig.rig.near_breasts import near_breasts

RIGHT = FitSignals(
    clearness=0.15,
    seen=0.78,
    distance_p95=0.002,
    beyond=0.002,
    angle_p90=0.15,
    explained=0.995,
    facing=0.98,
    stretch=0.1,
    limits=0.03,
)
LIMITS = verdict_limits(read_rig(default_rig_path()))
assert LIMITS is not None
NAMES = list(LIMITS.signals)
NONE = GivenLandmarks(picked=0, left=12, followed=0)
AGREED = replace(NONE, agreed=12)
SOME = GivenLandmarks(picked=9, left=3, followed=9)
ALL = GivenLandmarks(picked=12, left=0, followed=12)
PAIR = PickIssue(
    ("nipple_L", "nipple_R"), "nipple_L and nipple_R look exchanged; they were not followed.", exchanged=True
)
NAVEL = PickIssue(
    ("umbilicus",), "umbilicus is 40 mm from where it is expected; it was followed. Is it right?", followed=True
)


def beyond_no_torso(*names: str) -> FitSignals:
    """A right fit but for these signals, which are a little beyond their limit."""
    return with_signals(dict.fromkeys(names, 1.05))


def with_signals(times: dict[str, float]) -> FitSignals:
    """A right fit but for these signals, so many times beyond their limits."""
    limits = {name: LIMITS.signals[name] for name in times}
    return replace(
        RIGHT, **{n: each.limit * (times[n] if each.above else 1.0 / times[n]) for n, each in limits.items()}
    )


def test_the_limits_stand_on_the_side_that_they_say() -> None:
    for name, limit in LIMITS.signals.items():
        assert (asdict(RIGHT)[name] < limit.limit) == limit.above, name


def test_a_right_fit_is_good_and_has_no_reasons() -> None:
    found = verdict(RIGHT, Status.CONVERGED, LIMITS, NONE)
    assert (found.level, found.reasons, found.is_torso) == ("good", (), True)
    placed = verdict(replace(RIGHT, clearness=np.nan), Status.CONVERGED, LIMITS, ALL)
    assert placed.level == "good"


@pytest.mark.parametrize("name", NAMES)
def test_one_signal_alone_is_to_be_checked_and_named(name: str) -> None:
    found = verdict(beyond_no_torso(name), Status.CONVERGED, LIMITS, NONE)
    assert (found.level, found.is_torso, len(found.reasons)) == ("check", True, 1)
    assert found.reasons[0].endswith(".")
    assert "{" not in found.reasons[0]


@pytest.mark.parametrize("name", NAMES)
def test_where_landmarks_place_the_fit_a_signal_that_no_right_fit_has_is_a_note(name: str) -> None:
    found = verdict(beyond_no_torso(name), Status.CONVERGED, LIMITS, ALL)
    assert (found.level, len(found.reasons)) == ("good", 0 if LIMITS.signals[name].scan_alone else 1)
    assert verdict(beyond_no_torso(name), Status.CONVERGED, LIMITS, replace(ALL, repeated=True)).level == "check"


@pytest.mark.parametrize("given", [NONE, ALL])
def test_what_right_fits_have_is_no_reason_whoever_has_placed_them(given: GivenLandmarks) -> None:
    assert verdict(with_signals(dict.fromkeys(NAMES, 0.95)), Status.CONVERGED, LIMITS, given) == Verdict("good", ())


def test_more_and_more_signals_make_it_unusable_and_then_no_torso() -> None:
    levels = [
        verdict(beyond_no_torso(*NAMES[:count]), Status.CONVERGED, LIMITS, NONE) for count in range(len(NAMES) + 1)
    ]
    for count, found in enumerate(levels):
        distances = [LIMITS.signals[name].distance or name for name in NAMES[:count]]
        assert len(found.reasons) == len(set(distances))
        of_torsos = sum(not LIMITS.signals[name].scan_alone for name in NAMES[:count])
        assert (found.level == "unusable") == (of_torsos >= LIMITS.unusable_at)
        assert found.is_torso == (of_torsos < LIMITS.refused_at)


def test_named_landmarks_are_not_refused_as_no_torso() -> None:
    for given, level in ((ALL, "check"), (GivenLandmarks(picked=3, left=9, followed=3), "unusable")):
        found = verdict(beyond_no_torso(*NAMES), Status.CONVERGED, LIMITS, given)
        assert (found.level, found.is_torso) == (level, True)


def test_the_strongest_reasons_come_first_and_make_one_sentence() -> None:
    far = replace(beyond_no_torso(*NAMES), explained=0.4)
    found = verdict(far, Status.CONVERGED, LIMITS, NONE)
    assert "40 %" in found.reasons[0]
    assert found.refusal("torso", NONE).startswith("This does not look like a torso: the model explains only 40 %")
    assert found.refusal("torso", NONE).count(". ") == 0
    assert found.refusal("torso", NONE).endswith(".")
    assert len(found.refusal("torso", NONE)) < 400


def test_what_is_far_from_the_breasts_is_to_be_checked_and_condemns_no_fit() -> None:
    far = beyond_no_torso(*NAMES)
    found = verdict(far, Status.CONVERGED, LIMITS, NONE, near=RIGHT)
    assert (found.level, found.is_torso) == ("check", True)
    assert len(found.reasons) == 1
    assert found.reasons[0].startswith("With what is far from the breasts: ")
    placed = verdict(far, Status.CONVERGED, LIMITS, ALL, near=RIGHT)
    assert placed.level == "good"
    assert placed.reasons[0].startswith("With what is far from the breasts: ")
    both = verdict(far, Status.CONVERGED, LIMITS, NONE, near=far)
    assert (both.level, both.is_torso, both.reasons) == (
        "unusable",
        False,
        verdict(far, Status.CONVERGED, LIMITS, NONE).reasons,
    )


def test_what_speaks_against_the_breasts_alone_is_said_with_its_own_number() -> None:
    found = verdict(RIGHT, Status.CONVERGED, LIMITS, ALL, near=replace(beyond_no_torso(*NAMES), explained=0.4))
    assert found.level == "check"
    assert "40 %" in found.reasons[0]
    assert not any("far from the breasts" in each for each in found.reasons)


def test_a_refusal_speaks_of_the_unit_only_where_the_size_is_unusual() -> None:
    found = verdict(beyond_no_torso(*NAMES), Status.CONVERGED, LIMITS, NONE)
    assert "unit" not in found.refusal("torso", NONE)
    assert "check scan and unit" in found.refusal("torso", NONE, unusual_size=True)


def test_an_unusual_size_is_asked_about_and_only_an_unlikely_one_is_to_be_checked() -> None:
    tall = Reason("The trunk is 14 % larger", ("measure her",), note=True)
    assert verdict(RIGHT, Status.CONVERGED, LIMITS, ALL, asked=(tall,)) == Verdict("good", (str(tall),))
    assert verdict(RIGHT, Status.CONVERGED, LIMITS, ALL, asked=(replace(tall, note=False),)).level == "check"


def test_near_the_breasts_are_the_breasts_and_the_breastbone_but_no_arms_and_no_hips() -> None:
    rig = read_rig(default_rig_path())
    near = near_breasts(rig)
    names = ("nipple_L", "nipple_R", "mid_sternum", "xiphoid", "inframammary_fold_L", "inframammary_fold_R")
    assert near[rig.faces[rig.landmark_points(names).faces]].all()
    assert not near[rig.faces[rig.landmark_points(("umbilicus",)).faces]].any()
    for bone in ("upper_arm_L", "upper_arm_R", "pelvis", "neck"):
        assert not near[rig.skin_weights[:, rig.bone_names.index(bone)] > 0.6].any()


def test_a_fit_that_did_not_come_to_rest_is_to_be_checked() -> None:
    for status in (Status.OUT_OF_ITERATIONS, Status.STALLED):
        found = verdict(RIGHT, status, LIMITS, ALL)
        assert found.level == "check"
        assert "did not converge" in found.reasons[0]


def test_a_model_that_found_no_skin_at_all_is_refused() -> None:
    nothing = replace(RIGHT, seen=0.0, distance_p95=np.nan, beyond=np.nan, angle_p90=np.nan, explained=np.nan)
    found = verdict(nothing, Status.STALLED, LIMITS, NONE)
    assert not found.is_torso
    assert "found no skin" in found.refusal("torso", NONE)


def test_of_another_model_nothing_is_known() -> None:
    assert verdict_limits(toy_rig()) is None
    found = verdict(RIGHT, Status.CONVERGED, None, NONE)
    assert (found.level, found.reasons, found.is_torso) == (
        "uncalibrated",
        ("Not calibrated for this rig: nobody has measured what its right fits look like; judge this one by eye.",),
        True,
    )
    assert verdict(RIGHT, Status.STALLED, None, NONE).level == "check"
    assert verdict(replace(RIGHT, explained=np.nan), Status.CONVERGED, None, NONE).level == "unusable"


def test_landmarks_in_doubt_make_a_right_fit_worth_a_look() -> None:
    def judged(*doubts: PickIssue) -> Verdict:
        return verdict(RIGHT, Status.CONVERGED, LIMITS, ALL, of_doubts(doubts))

    notch = PickIssue(("suprasternal_notch",), "It is elsewhere.")
    one, two = judged(NAVEL), judged(NAVEL, notch)
    assert one.level == two.level == "check"
    assert one.reasons == ("One landmark is in doubt; look at what is asked about it.",)
    assert two.reasons == ("2 landmarks are in doubt; look at what is asked about them.",)
    assert judged(NAVEL, PAIR).reasons == (
        "2 landmarks look exchanged between left and right, and one landmark is in doubt; look at what is asked about "
        "them.",
    )


def test_a_landmark_in_doubt_that_is_far_from_the_breasts_is_a_note() -> None:
    (note,) = of_doubts((NAVEL,), {"umbilicus"})
    assert verdict(RIGHT, Status.CONVERGED, LIMITS, ALL, (note,)) == Verdict("good", (str(note),))
    notch = PickIssue(("suprasternal_notch",), "It is elsewhere.")
    for doubts in ((NAVEL, notch), (PAIR,)):
        (reason,) = of_doubts(doubts, {"umbilicus", *PAIR.names})
        assert not reason.note


def test_a_part_of_a_body_is_to_be_checked_unless_landmarks_say_where_it_belongs() -> None:
    part = replace(RIGHT, seen=0.33)
    alone = verdict(part, Status.CONVERGED, LIMITS, NONE)
    assert alone.level == "check"
    assert alone.reasons[0].startswith("The scan shows only 33 % of the body")
    assert verdict(replace(part, clearness=np.nan), Status.CONVERGED, LIMITS, ALL).level == "good"


def test_a_fit_is_as_good_as_the_lines_that_it_places() -> None:
    def judged(error: float | None, given: GivenLandmarks) -> Verdict:
        return verdict(RIGHT, Status.CONVERGED, LIMITS, given, line_error=error)

    agreed = "12 landmarks were only agreed to where they were proposed; they keep the proposals' errors."
    assert judged(None, NONE) == Verdict("good", ())
    assert judged(0.009, replace(SOME, agreed=3)) == Verdict("good", (agreed.replace("12", "3"),))
    assert judged(0.0146, AGREED) == Verdict(
        "check",
        (
            "Lines may be far off; place at least three landmarks by hand, or plan with their margin.",
            agreed,
        ),
    )
    assert judged(0.009, NONE).level == judged(0.009, ALL).level == "good"  # whoever has placed it
    assert judged(0.0091, NONE).level == judged(0.0091, ALL).level == "check"
    assert judged(0.0196, SOME).reasons == (
        "Lines may be far off; place more landmarks by hand, or plan with their margin.",
    )
    assert judged(0.0196, ALL) == Verdict("check", ("Lines may be far off; plan with their margin.",))
    assert judged(0.3, AGREED) == Verdict(
        "unusable",
        ("Where lines on the breasts lie is not known; place at least three landmarks by hand.", agreed),
    )
    assert judged(0.3, ALL).reasons == ("Where lines on the breasts lie is not known.",)


STRENGTHS = (0.9, 1.5)  # times its limit


def all_verdicts() -> Iterator[tuple[str, GivenLandmarks, Verdict]]:
    """Every combination of what decides, with signals alone and together."""
    each = [{name: strength} for name, strength in product(NAMES, STRENGTHS)]
    together = [dict.fromkeys(NAMES[:count], s) for count in range(2, len(NAMES) + 1) for s in STRENGTHS]
    signals = [RIGHT, *(with_signals(one) for one in (*each, *together))]
    signals.append(replace(RIGHT, distance_p95=np.nan, explained=np.nan))
    landmarks = [
        replace(given, agreed=agreed, repeated=repeated)
        for given, agreed, repeated in product((NONE, SOME, ALL), (0, 1, 3), (False, True))
        if agreed <= given.left and not (repeated and not given.placed)
    ] + [replace(ALL, followed=0)]  # exchanged, so that none was followed
    doubts: tuple[tuple[PickIssue, ...], ...] = ((), (NAVEL,), (PAIR,), (PAIR, NAVEL))
    for shown, status, known, given, asked, error in product(
        signals, (Status.CONVERGED, Status.STALLED), (LIMITS, None), landmarks, doubts, (None, 0.005, 0.02, 0.1)
    ):
        if given.picked or not asked:  # doubts are of picks
            found = verdict(shown, status, known, given, of_doubts(asked), error)
            text = " ".join(found.reasons) if found.is_torso else found.refusal("torso", given)
            yield text, given, found


@pytest.mark.slow
def test_no_verdict_gives_advice_that_was_followed_or_says_a_thing_twice() -> None:
    """In no combination: what is placed is not to be placed, no advice comes twice, none contradicts its level."""
    seen = set()
    for text, given, found in all_verdicts():
        if (text, given, found.level) in seen:
            continue
        seen.add((text, given, found.level))
        beside_agreed = {*found.reasons} - {str(each) for each in of_agreed(given)}
        assert beside_agreed if found.level != "good" else given.on_their_own or not beside_agreed
        if found.is_torso and "found no skin" not in text:
            assert text.count("only agreed to") == (given.agreed > 0), text
        assert given.left or "place " not in text, text
        assert not (given.picked and "at least three" in text), text
        parts = [part for reason in found.reasons for part in reason.rstrip(".").split("; ")]
        assert len(parts) == len(set(parts)), text
        advice = [
            each for reason in found.reasons for each in reason.rstrip(".").partition("; ")[2].split(", or ") if each
        ]
        assert len(advice) == len(set(advice)), text
        facts = [fact for fact, of_same in SAME.items() if any(each in text for each in of_same)]
        assert all(sum(each in text for each in SAME[fact]) == 1 for fact in facts), text
        if found.level == "unusable":
            assert "margin" not in text, text
            assert "may be" not in text, text
        if not found.is_torso:
            assert text.startswith("This does not look like a torso: ")
            assert "mm off" not in text
        assert ".." not in text
        assert ";." not in text
    assert len(seen) > 1000


SAME = {  # what would say the same in other words
    "model far from the scan": ("places of the model is more than", "of the model that has scan lies more than"),
    "landmarks": ("place at least three", "place more", "or place landmarks if"),
    "lines": ("may be", "is not known"),
    "doubt": ("is in doubt", "are in doubt"),
}


def test_picks_where_they_were_proposed_tell_nothing() -> None:
    proposed = {"xiphoid": np.zeros(3), "umbilicus": np.array([0.0, -0.15, 0.0])}
    picks = {
        "xiphoid": np.array([0.001, 0.0, 0.0]),
        "umbilicus": np.array([0.003, -0.15, 0.0]),
        "nipple_L": np.array([0.1, 0.0, 0.0]),
    }
    assert picked_names(picks, proposed) == {"umbilicus", "nipple_L"}


def test_repeated_proposals_do_not_place_a_part() -> None:
    part = replace(RIGHT, seen=0.57)
    assert shows_a_part(part, LIMITS)
    assert not shows_a_part(RIGHT, LIMITS)
    assert verdict(part, Status.CONVERGED, LIMITS, ALL).level == "good"
    assert verdict(part, Status.CONVERGED, LIMITS, replace(ALL, repeated=True)).level == "check"
    assert verdict(RIGHT, Status.CONVERGED, LIMITS, replace(ALL, repeated=True)).level == "good"


def test_no_fit_is_good_in_a_stance_that_the_limits_were_not_chosen_on() -> None:
    without = LIMITS.model_copy(update={"stances": ("standing", "supine")})

    def level(stance: str) -> Verdict:
        return verdict(RIGHT, Status.CONVERGED, without, ALL, stance=stance)

    assert level("standing") == level("supine") == Verdict("good", ())
    assert level("prone") == Verdict(
        "check", ("How far off a fit of a prone body may be has not been measured; look at it closely.",)
    )


def test_a_prone_bodys_front_is_all_that_its_scan_shows_and_nothing_of_that_counts_for_others() -> None:
    front = replace(RIGHT, seen=0.5)
    assert verdict(front, Status.CONVERGED, LIMITS, NONE, stance="prone").level == "good"
    assert verdict(front, Status.CONVERGED, LIMITS, NONE, stance="standing").level == "check"
    head_down = replace(RIGHT, beyond=0.09, angle_p90=0.48, distance_p95=0.0085)
    assert verdict(head_down, Status.CONVERGED, LIMITS, NONE, stance="prone").level == "unusable"
    assert LIMITS.in_stance("standing") == LIMITS == LIMITS.in_stance("supine")
