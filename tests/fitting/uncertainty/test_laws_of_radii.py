"""Radii are what they are said to be: nine of ten of a Gaussian, sums of squares, and in proportion to the errors."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from helpers.forearm import forearm_rig, posed_forearm

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.line_error import ACROSS
from breastrig.fitting.fit import FitTask, ScanProblem, fit_iterates
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.uncertainty import radii as radii_module
from breastrig.fitting.uncertainty.radii import (
    HOLDS_90,
    NO_PICKS,
    Calibration,
    Radii,
    Scatter,
    radii,
    scatter_of,
    seen_vertices,
    shows_part,
)
from breastrig.rig.model import Rig
from breastrig_studies.studies.trust.laplace import rises

STATES = ("given", "others", "alone", "proposed", "seen", "hidden", "seen_alone", "hidden_alone")
NUMBERS = {
    "expected_scatter": 1.25,
    "freedom_given": 4.0,
    "freedom_elsewhere": 16.0,
    "usual_strain": 0.04,
    "without_picks": {"clear": 0.2, "unclear": 0.05, "astray": 0.25},
}
FACTORS = {state: {"other": 2.0 + k} for k, state in enumerate(STATES)}  # of each state another one
KNOWN = Calibration.model_validate(NUMBERS | {"stances": {"standing": FACTORS}})


def draws(axes: int, count: int = 200_000) -> Array:
    """(N, 3) of variance one in all, shared by so many axes."""
    found = np.zeros((count, 3))
    found[:, :axes] = np.random.default_rng(axes).normal(size=(count, axes)) / np.sqrt(axes)
    return found


def test_a_variance_of_one_in_all_is_held_with_nine_of_ten_and_a_line_across_it() -> None:
    in_space = [float((np.linalg.norm(draws(axes), axis=1) <= HOLDS_90).mean()) for axes in (1, 2, 3)]
    assert np.mean(in_space) == pytest.approx(0.9, abs=0.01)
    across = [float((np.abs(draws(axes)[:, 0]) <= ACROSS * HOLDS_90).mean()) for axes in (2, 3)]
    assert across[0] == pytest.approx(0.9, abs=0.04)  # the skin has two axes
    assert across[1] >= 0.9


def test_picks_enlarge_radii_by_their_scatter_the_more_the_more_there_are() -> None:
    """From none on, without a step; two axes of eight picks count as much as the sixteen that are expected."""
    for given in (True, False):
        assert KNOWN.enlarged(NO_PICKS, given=given) == 1.0
        assert KNOWN.enlarged(Scatter(1.25, 7), given=given) == pytest.approx(1.0)
        assert KNOWN.enlarged(Scatter(2.5, 10**6), given=given) == pytest.approx(2.0, rel=1e-3)
        for scatter in (0.1, 0.75, 2.5, 7.0):
            by_picks = np.array([KNOWN.enlarged(Scatter(scatter, picks), given=given) for picks in range(13)])
            assert (np.sign(scatter - 1.25) * np.diff(by_picks) > 0.0).all()
    assert KNOWN.enlarged(Scatter(2.5, 8), given=False) == pytest.approx(np.sqrt((1.0 + 4.0) / 2.0))
    assert KNOWN.enlarged(Scatter(2.5, 2), given=True) == pytest.approx(np.sqrt((1.0 + 4.0) / 2.0))


def test_the_less_clear_a_start_was_the_farther_the_body_may_be() -> None:
    lost = [KNOWN.without_picks.lost(margin) for margin in (0.3, 0.2, 0.125, 0.05, 0.0)]
    assert lost == pytest.approx([0.0, 0.0, 0.125, 0.25, 0.25])


@pytest.fixture(scope="module")
def forearm() -> Posterior:
    """Of a scan from the palm's side, with two of five landmarks."""
    rig = forearm_rig()
    skin, _ = posed_forearm(rig)
    shown = skin[:, 2] > np.quantile(skin[:, 2], 0.35)
    target = ScanTarget(skin, rig.faces[shown[rig.faces].all(axis=1)])
    places = dict(zip(rig.landmark_names, rig.landmark_points().positions(skin, rig.faces), strict=True))
    picks = {name: places[name] for name in ("elbow_crease", "wrist_crease")}
    recipe = load_recipe("default").model_copy(update={"body": None})
    task = FitTask(rig, target, start_from_landmarks(rig, places), recipe, {}).with_picks(picks)
    return Posterior(task, list(fit_iterates(task))[-1].parameters)


def test_the_energy_rises_around_a_fit_as_its_covariance_says(forearm: Posterior) -> None:
    """One standard deviation away, in any direction that is drawn, by one half."""
    one, *_ = rises(forearm)
    assert np.median(one) == pytest.approx(1.0, abs=0.15)


def test_a_covariance_is_the_inverse_of_what_scan_and_priors_say_and_of_nothing_else(forearm: Posterior) -> None:
    """Joints and limits with it; what keeps the inverse finite weighs next to nothing."""
    problem, stage = ScanProblem(forearm.task), forearm.task.recipe.stages[-1]
    terms = problem.terms(stage, 1.0, forearm.state, problem.matches(stage, 1.0, forearm.state))
    assert "joint_rest" in {term.name for term in (*problem.priors, *terms.residuals)}
    wanted = problem.system(terms, forearm.state).hessian
    found = np.linalg.inv(forearm.covariance())
    assert np.diag(found) == pytest.approx(np.diag(wanted), rel=1e-3)


def test_the_variance_of_a_landmark_is_that_of_all_three_axes(forearm: Posterior) -> None:
    names = tuple(forearm.task.rig.landmark_names)
    spread = forearm.landmark_covariances(names)
    assert forearm.landmark_variances(names) == pytest.approx(spread[:, [0, 1, 2], [0, 1, 2]].sum(axis=1))
    corners = forearm.task.rig.landmark_points(names)
    vertices = forearm.vertex_variances()[forearm.task.rig.faces[corners.faces]]
    at_corner = corners.barycentric.max(axis=1) > 1.0 - 1e-9
    assert at_corner.any()
    nearest = np.take_along_axis(vertices, corners.barycentric.argmax(axis=1)[:, None], axis=1)[:, 0]
    assert forearm.landmark_variances(names)[at_corner] == pytest.approx(nearest[at_corner])


Asked = Callable[..., Radii]


@pytest.fixture
def asked(forearm: Posterior, monkeypatch: pytest.MonkeyPatch) -> Asked:
    """Its radii, by factors that are known, as if its picks scattered so and were picked or seen by colour."""

    def answer(
        margin: float | None = None,
        scatter: Scatter = NO_PICKS,
        expected: bool = False,
        strain: float = 0.04,
        **task: object,
    ) -> Radii:
        monkeypatch.setattr(radii_module, "calibration", lambda _: KNOWN)
        monkeypatch.setattr(radii_module, "scatter_of", lambda _: scatter)
        posed: Any = SimpleNamespace(
            task=SimpleNamespace(
                **{name: getattr(forearm.task, name) for name in ("rig", "stance", "recipe", "target")}
            ),
            state=forearm.state,
            strain=strain,
            joint_landmark_covariance=forearm.joint_landmark_covariance,
            vertex_variances=forearm.vertex_variances,
        )
        posed.task.picked, posed.task.given = forearm.task.picked, forearm.task.given
        vars(posed.task).update(task)
        found = radii(posed, margin, expected=expected)
        assert found is not None
        return found

    return answer


def test_a_radius_is_its_factor_times_the_deviation_and_what_the_start_leaves_open(
    forearm: Posterior, asked: Asked
) -> None:
    """Squares add up: what the picks' scatter and the state of a place make of its deviation, and an unclear start."""
    rig, seen = forearm.task.rig, seen_vertices(forearm)
    assert 0.3 < seen.mean() < 0.8
    names = tuple(rig.landmark_names)
    at, skin = np.sqrt(forearm.landmark_variances(names)), np.sqrt(forearm.vertex_variances())
    given = np.array([name in forearm.task.given for name in names])
    factor = {state: FACTORS[state]["other"] for state in STATES}
    alone: dict[str, object] = {"picked": {}, "given": {}}
    for margin, lost in ((None, 0.0), (0.3, 0.0), (0.125, HOLDS_90 * 0.125), (0.0, HOLDS_90 * 0.25)):
        for scatter in (NO_PICKS, Scatter(0.75, 2), Scatter(2.5, 9)):
            found = asked(margin, scatter)
            at_picks, times = (KNOWN.enlarged(scatter, given=each) for each in (True, False))
            wanted = np.where(given, at_picks * factor["given"], times * factor["others"]) * at
            assert [*found.landmarks.values()] == pytest.approx(np.hypot(wanted, lost))
            wanted = np.where(seen, times * factor["seen"], max(times, 1.0) * factor["hidden"]) * skin
            assert found.vertices == pytest.approx(np.hypot(wanted, lost))
            assert found.lines == pytest.approx(ACROSS * np.sqrt(np.mean(found.vertices[seen] ** 2)))
        for expected, state in ((False, "alone"), (True, "proposed")):
            found = asked(margin, NO_PICKS, expected, **alone)
            assert [*found.landmarks.values()] == pytest.approx(np.hypot(factor[state] * at, lost))
            wanted = np.where(seen, factor["seen_alone"], factor["hidden_alone"]) * skin
            assert found.vertices == pytest.approx(np.hypot(wanted, lost))


def test_all_radii_grow_with_the_strain_of_the_fit_and_what_the_start_leaves_open_does_not(
    forearm: Posterior, asked: Asked
) -> None:
    usual, twice, without_scan = (asked(strain=strain) for strain in (0.04, 0.08, np.nan))
    assert [*twice.landmarks.values()] == pytest.approx([2.0 * each for each in usual.landmarks.values()])
    for name in ("vertices", "joint", "once_picked"):
        times = 4.0 if name == "joint" else 2.0
        np.testing.assert_allclose(getattr(twice, name), times * getattr(usual, name))
        np.testing.assert_array_equal(getattr(without_scan, name), getattr(usual, name))
    assert asked(0.0, strain=0.08).lost == asked(0.0).lost
    assert np.isnan(forearm.strain)  # nothing is known of forearms together
    never_measured = KNOWN.model_copy(update={"usual_strain": None})
    assert never_measured.strained(7.0, part=False) == 1.0
    times = [[KNOWN.strained(0.04 * each, part=part) for each in (0.1, 0.9, 3.0)] for part in (False, True)]
    assert times == [pytest.approx([0.75, 0.9, 3.0]), pytest.approx([1.0, 1.0, 3.0])]


def test_the_strain_of_bodies_as_they_were_expected_is_the_root_of_their_distance_to_the_scan() -> None:
    """Of linear Gaussian bodies, however much of them the scan shows; of those that spread twice as far twice that."""
    random, count = np.random.default_rng(8), 12
    for seen in (2, 8, 40):
        prior, scan = random.normal(size=(count, count)), random.normal(size=(seen, count))
        hessian = prior.T @ prior + scan.T @ scan
        half = np.linalg.cholesky(np.linalg.inv(hessian))
        for times in (1.0, 2.0):
            found = []
            for _ in range(400):
                body = np.linalg.solve(prior, times * random.normal(size=count))
                observed = scan @ body + times * random.normal(size=seen)
                term = SimpleNamespace(residual=prior @ np.linalg.solve(hessian, scan.T @ observed), jacobian=prior)
                fit: Any = SimpleNamespace(
                    expected=[SimpleNamespace(name="body_prior", linearise=lambda _, term=term: term)],
                    state=None,
                    distance=0.01,
                    whitened=lambda rows, half=half: rows @ half,
                )
                found.append(Posterior.strain.func(fit) ** 2)
            assert np.mean(found) == pytest.approx(0.01 * times**2, rel=0.1)


def test_nipples_that_colour_shows_where_the_form_has_them_clear_the_start(asked: Asked) -> None:
    nipples = {"nipple_L": None, "nipple_R": None}
    unclear, seen, one = (asked(0.0, picked={}, given=given).vertices for given in ({}, nipples, {"nipple_L": None}))
    assert (unclear > 0.25).all()
    assert (one > 0.25).all()
    assert (seen < unclear).all()
    assert seen.max() < 0.25
    picked = asked(0.0, picked=nipples, given=nipples).vertices  # a person's picks are not what colour shows
    assert (picked > 0.25).all()


def test_what_is_seen_by_colour_counts_as_given(forearm: Posterior, asked: Asked) -> None:
    one = forearm.task.rig.landmark_names[0]
    found = asked(picked={}, given={one: None}).landmarks[one]
    assert found == pytest.approx(FACTORS["given"]["other"] * np.sqrt(forearm.landmark_variances((one,))[0]))


@pytest.mark.parametrize("reverse", [False, True])
def test_where_regions_overlap_the_less_sure_one_counts(forearm: Posterior, reverse: bool) -> None:
    rig = forearm.task.rig
    kinds = {"arm": np.arange(300), "wrist": np.arange(200, 500)}
    regions = dict(reversed(kinds.items())) if reverse else kinds
    factors = KNOWN.of_stance("standing").model_copy(update={"seen": {"arm": 2.0, "wrist": 5.0, "other": 3.0}})
    posterior: Any = SimpleNamespace(
        task=SimpleNamespace(rig=replace(rig, regions=regions), picked={"a": 1}, recipe=forearm.task.recipe),
        state=forearm.state,
    )
    found = radii_module.skin_factors(posterior, factors, np.ones(len(rig.template), dtype=np.bool_))
    assert found.tolist() == [2.0] * 200 + [5.0] * 300 + [3.0] * (len(rig.template) - 500)


def picks_off_by(deviations: Array) -> Any:
    names = dict.fromkeys(range(len(deviations)))
    return SimpleNamespace(picks=names, task=SimpleNamespace(picked=names), of_picks_alone=deviations)


def test_picks_as_good_as_is_said_scatter_by_one_and_a_wild_one_hardly_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        radii_module, "LeaveOneOut", lambda found: SimpleNamespace(deviations=lambda: dict(enumerate(found)))
    )
    usual = np.linalg.norm(np.random.default_rng(3).normal(size=(4000, 2)), axis=1)  # along the skin's two axes
    assert scatter_of(picks_off_by(usual)) == (pytest.approx(1.0, abs=0.02), 4000)
    close = usual[usual < 2.0]
    wider = scatter_of(picks_off_by(2.5 * close)).deviation
    assert wider == pytest.approx(2.5 * scatter_of(picks_off_by(close)).deviation, rel=1e-6)
    twelve = usual[:12].copy()
    far = np.append(twelve, 1e3)
    farther = np.append(twelve, 1e6)
    assert scatter_of(picks_off_by(far)) == scatter_of(picks_off_by(farther))
    assert scatter_of(picks_off_by(far)).deviation < 2.5  # ten deviations among twelve usual ones
    assert scatter_of(picks_off_by(usual[:1])).picks == 1
    assert scatter_of(picks_off_by(usual[:0])) == NO_PICKS
    beside = picks_off_by(twelve)  # what colours show is no click
    beside.task.picked = [0, 1]
    of_two = float(np.sqrt(np.mean(twelve[:2] ** 2) / 2.0))
    assert scatter_of(beside) == (pytest.approx(of_two), 2)


def test_a_scan_that_faces_elsewhere_shows_no_skin(forearm: Posterior) -> None:
    seen, task = seen_vertices(forearm), forearm.task
    inside_out = replace(task, target=ScanTarget(task.target.vertices, task.target.faces[:, ::-1]))
    posterior: Any = SimpleNamespace(task=inside_out, state=forearm.state)
    assert seen.any()
    assert not seen_vertices(posterior)[seen].any()


def test_a_larger_error_anywhere_makes_no_radius_smaller(asked: Asked) -> None:
    careful, careless = Scatter(0.5, 8), Scatter(1.5, 8)
    sure = asked(0.2, careful)
    for less in (asked(0.1, careful), asked(0.2, careless), asked(0.1, careless)):
        assert (less.vertices >= sure.vertices).all()
        assert all(less.landmarks[name] >= radius for name, radius in sure.landmarks.items())
        assert less.lines > sure.lines


def test_the_rig_without_numbers_has_no_radii(forearm: Posterior) -> None:
    rig: Rig = forearm.task.rig
    assert not rig.known
    assert radii(forearm) is None


@pytest.mark.parametrize(("seen", "part"), [(0.57, True), (0.74, False)])
def test_a_scan_of_a_part_of_the_body_is_known_by_how_much_of_the_model_it_shows(seen: float, part: bool) -> None:
    """The largest share of a part, and the smallest of a whole body, that were met."""
    assert shows_part(np.arange(100) < 100 * seen) is part
