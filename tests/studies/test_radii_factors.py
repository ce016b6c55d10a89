"""Factors of radii, on errors whose distribution is known: they hold nine of ten places of women who come later."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from breastrig.fitting.uncertainty.radii import NO_PICKS, Calibration, Scatter
from breastrig_studies import radii_factors
from breastrig_studies.cohort import DEVELOPMENT, VALIDATION
from breastrig_studies.radii_factors import OTHER, Known, Score, factors, quantile, scores_of, table

CALIBRATION = Calibration.model_validate(
    {
        "expected_scatter": 1.0,
        "usual_strain": 1.0,
        "freedom_given": 1e-9,  # the picks alone say
        "freedom_elsewhere": 1e-9,
        "without_picks": {"clear": 0.2, "unclear": 0.05, "astray": 0.2},
    }
)


def test_nine_of_ten_places_of_a_new_woman_are_held_however_many_each_known_one_has() -> None:
    """Women of whom much is known are of those whose errors are small; each counts alike all the same."""
    rng = np.random.default_rng(1)

    def woman() -> tuple[float, int]:
        size = float(rng.choice([0.5, 1.0, 2.0]))
        return size, {0.5: 200, 1.0: 40, 2.0: 10}[size]

    held = []
    for _ in range(400):
        known = [woman() for _ in range(15)]
        scores = [np.abs(rng.normal(0.0, size, count)) for size, count in known]
        names = [str(k) for k, (_, count) in enumerate(known) for _ in range(count)]
        size, _ = woman()
        limit = quantile(np.concatenate(scores).tolist(), names)
        held.append(float(np.mean(np.abs(rng.normal(0.0, size, 200)) <= limit)))
    assert 0.895 < np.mean(held) < 0.96  # of 15 women one more, the worst, counts as well


def known_women(seed: int, women: int, places: int) -> Known:
    """Errors are deviations times the fit's strain, and 2 (seen) or 3 or what picks that scatter so make of these.

    Of hidden skin that is at least 3.
    """
    rng, found = np.random.default_rng(seed), []
    for number in range(women):
        scatter, strain = float(rng.choice([0.5, 1.0, 2.0])), float(rng.choice([1.0, 2.0]))
        for state, kind, size in (("given", "nipple", 2.0), ("hidden", "back", 3.0), ("seen_alone", "belly", 1.0)):
            scale = strain * size * (1.0 if "alone" in state else max(scatter, 1.0) if state == "hidden" else scatter)
            for error in scale * np.linalg.norm(rng.normal(size=(places, 2)), axis=1):
                some = NO_PICKS if "alone" in state else Scatter(scatter, 9)
                found.append((f"w{number}", "standing", Score(state, kind, float(error), 0.004, strain, False, *some)))
    return found


def test_factors_are_those_of_the_errors_without_what_the_picks_scatter_makes_of_them() -> None:
    of_90 = np.sqrt(2.0 * np.log(10.0))  # of a place in the skin's two axes
    found = factors(known_women(2, 80, 60), CALIBRATION)["standing"]
    sizes = {state: found[state][kind] for state, kind in (("given", "nipple"), ("hidden", "back"))}
    assert sizes["given"] == pytest.approx(2.0 * of_90, rel=0.05)
    assert sizes["hidden"] == pytest.approx(3.0 * of_90, rel=0.05)
    assert found["seen_alone"]["belly"] == pytest.approx(of_90, rel=0.05)
    two = [
        *known_women(2, 20, 20),
        *((w, s, replace(each, kind="areola", score=1.0)) for w, s, each in known_women(3, 20, 5)),
    ]
    of_kinds = factors(two, CALIBRATION)["standing"]
    for state in ("given", "hidden", "seen_alone"):
        kinds = {kind: value for kind, value in of_kinds[state].items() if kind != OTHER}
        assert len(kinds) == 2
        assert of_kinds[state][OTHER] == max(kinds.values())  # of what nobody has measured, the worst
    lines = [*table(known_women(4, 200, 40), CALIBRATION.model_copy(update={"stances": _stances(found)}))]
    for line in lines:
        assert float(line.split()[2].rstrip("%")) == pytest.approx(90.0, abs=2.0), line


def _stances(found: dict[str, dict[str, float]]) -> dict[str, Any]:
    return {
        "standing": Calibration.model_validate(CALIBRATION.model_dump() | {"stances": {"standing": found}}).stances[
            "standing"
        ]
    }


def test_a_score_is_the_error_over_the_standard_deviation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Around the model's place, and of a fit without picks also around where the landmark is expected."""
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    points = SimpleNamespace(positions=lambda *_: vertices[:1] + 0.0)
    rig = SimpleNamespace(
        landmark_names=["nipple_L"], landmark_points=lambda: points, faces=None, regions={"breast_L": np.array([1, 2])},
        template=vertices,
    )  # fmt: skip
    scene: Any = SimpleNamespace(
        landmarks={"nipple_L": np.array([0.004, 0.0, 0.0])}, case=SimpleNamespace(stance="standing")
    )
    true: Any = SimpleNamespace(vertices=vertices + np.array([0.0, 0.006, 0.0]))
    for name, value in (
        ("scatter_of", NO_PICKS),
        ("seen_vertices", np.array([True, True, False])),
    ):
        monkeypatch.setattr(radii_factors, name, lambda *_, value=value: value)
    monkeypatch.setattr(radii_factors, "expected_places", lambda *_: np.array([[0.004, 0.0, 0.01]]))
    for picked, ways in (
        ({"nipple_L": 1}, {"given": 2.0}),
        ({"xiphoid": 1}, {"others": 2.0}),
        ({}, {"alone": 2.0, "proposed": 5.0}),
    ):
        posterior: Any = SimpleNamespace(
            task=SimpleNamespace(rig=rig, picked=picked, recipe=None), state=SimpleNamespace(vertices=vertices),
            landmark_variances=lambda _: np.array([0.002**2]), vertex_variances=lambda: np.full(3, 0.003**2),
            strain=1.5,
        )  # fmt: skip
        found = {each.state: each for each in scores_of(posterior, scene, true) if each.kind == "nipple"}
        assert {state: each.score for state, each in found.items()} == pytest.approx(ways)
        skin = {each.state: each.score for each in scores_of(posterior, scene, true) if each.kind == "breast"}
        more = "" if picked else "_alone"
        assert skin == pytest.approx({f"seen{more}": 2.0, f"hidden{more}": 2.0})


def errors_of(state: str, size: float, women: int, picks: int = 0) -> Known:
    """Of so many women 60 places in the skin's two axes, with deviations that are to be `size` times larger."""
    rng, known = np.random.default_rng(picks), []
    for woman in range(women):
        for error in size * np.linalg.norm(rng.normal(size=(60, 2)), axis=1):
            known.append((f"w{woman}", "standing", Score(state, "nipple", float(error), 0.004, 1.0, False, 1.0, picks)))
    return known


def test_a_place_without_picks_has_at_least_the_factor_that_it_has_beside_some() -> None:
    """So that the first pick makes it no less sure; of what has no factor of its own likewise."""
    for with_picks, without in ((3.0, 2.0), (2.0, 3.0)):
        found = factors(errors_of("others", with_picks, 40, 9) + errors_of("alone", without, 40), CALIBRATION)[
            "standing"
        ]
        of_90 = np.sqrt(2.0 * np.log(10.0))
        for kind in ("nipple", OTHER):
            assert found["others"][kind] == pytest.approx(with_picks * of_90, rel=0.06)
            assert found["alone"][kind] == pytest.approx(3.0 * of_90, rel=0.06)


def test_a_half_of_few_women_does_not_speak_for_others() -> None:
    """With fewer than fifteen women in the development half both halves estimate, otherwise that half alone."""
    one = Score("given", "nipple", 1.0, 0.004, 1.0, False)

    def of(half: str, stance: str, women: int) -> Known:
        return [(f"{half} {k}", stance, one) for k in range(women)]

    halves = {
        half: of(half, "prone", 10) + of(half, "standing", 20) + (of(half, "supine", 20) if half == VALIDATION else [])
        for half in (DEVELOPMENT, VALIDATION)
    }
    found = radii_factors.enough(halves)
    assert {woman for woman, at, _ in found if at == "standing"} == {f"{DEVELOPMENT} {k}" for k in range(20)}
    assert len({woman for woman, at, _ in found if at == "prone"}) == 20
    assert len({woman for woman, at, _ in found if at == "supine"}) == 20


def test_only_a_stance_of_few_development_patients_is_joined_by_the_validation_half() -> None:
    def known(half: str, stance: str, patients: int) -> Known:
        return [(f"{half} {k}", stance, SimpleNamespace()) for k in range(patients)]

    many, few = known("a", "standing", radii_factors.FEW), known("a", "prone", radii_factors.FEW - 1)
    others = known("b", "standing", 3), known("b", "prone", 3)
    halves = {DEVELOPMENT: many + few, VALIDATION: others[0] + others[1]}
    assert radii_factors.enough(halves) == many + few + others[1]
