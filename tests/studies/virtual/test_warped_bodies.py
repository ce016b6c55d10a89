"""Warped bodies: their proportions are what was drawn, both stances are one woman, and no triangle turned over."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.geometry.normals import face_areas
from breastrig_studies.virtual.bodies import read_bodies
from breastrig_studies.virtual.warped.body import (
    WarpedBody,
    breast_region,
    draw_body,
    is_sound,
    is_sound_hanging,
    warped_body,
)
from breastrig_studies.virtual.warped.make import source_of
from breastrig_studies.virtual.warped.numbers import Numbers
from breastrig_studies.virtual.warped.sources import Source, read_sources

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def sources() -> tuple[Source, ...]:
    return read_sources()


@pytest.fixture(scope="module")
def source(sources: tuple[Source, ...]) -> Source:
    return sources[2]


def made(source: Source, numbers: Numbers) -> WarpedBody:
    body = warped_body(source, source.lying[0], numbers)
    assert body is not None
    return body


def height(body: WarpedBody, above: str, below: str) -> float:
    return float(body.standing.landmarks[above][1] - body.standing.landmarks[below][1])


def test_no_source_is_in_both_halves_and_each_half_has_one(sources: tuple[Source, ...]) -> None:
    halves = {
        half: {source.sha256 + source.name for source in sources if source.half == half}
        for half in ("development", "validation")
    }
    assert not halves["development"] & halves["validation"]
    assert {source.name for source in sources if source.half == "development"} == {
        f"cohort_patient_{n}" for n in (1, 3, 5, 7)
    }
    for number in range(20):
        found = source_of(sources, number, np.random.default_rng(number))
        assert found.half == ("development", "validation")[number % 2]


def test_without_changes_the_body_is_her_source_in_both_stances(source: Source) -> None:
    body = made(source, Numbers())
    np.testing.assert_allclose(body.standing.vertices, source.standing, atol=1e-12)
    np.testing.assert_allclose(body.supine.vertices, source.lying[0].vertices, atol=1e-9)
    original = read_bodies().patients[2].bodies[0].landmarks
    shift = body.standing.landmarks["umbilicus"] - original["umbilicus"]
    for name, place in body.standing.landmarks.items():
        np.testing.assert_allclose(place - original[name], shift, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "above", "below"),
    [("notch_xiphoid", "suprasternal_notch", "xiphoid"), ("xiphoid_navel", "xiphoid", "umbilicus")],
)
@pytest.mark.parametrize("share", [-0.15])
def test_a_segment_becomes_longer_by_its_share_and_the_other_does_not(
    source: Source, name: str, above: str, below: str, share: float
) -> None:
    before, after = made(source, Numbers()), made(source, replace(Numbers(), **{name: share}))
    assert height(after, above, below) == pytest.approx((1.0 + share) * height(before, above, below), abs=5e-4)
    others = {("suprasternal_notch", "xiphoid"), ("xiphoid", "umbilicus")} - {(above, below)}
    for other in others:
        assert height(after, *other) == pytest.approx(height(before, *other), abs=5e-4)


def test_both_stances_correspond_and_the_back_stays_on_the_table(source: Source, rng: np.random.Generator) -> None:
    body = draw_body(source, rng)
    assert body.standing.vertices.shape == body.supine.vertices.shape == source.standing.shape
    lying = source.lying[0]
    touching = lying.vertices[:, 2] < lying.table + 0.004
    assert touching.sum() > 50
    np.testing.assert_allclose(body.supine.vertices[touching, 2], lying.vertices[touching, 2], atol=6e-4)
    for skin in (body.standing, body.supine):
        places = source.points.positions(skin.vertices, source.faces)
        for name, place in zip(source.names, places, strict=True):
            if name in skin.landmarks:
                np.testing.assert_array_equal(skin.landmarks[name], place)


@pytest.mark.parametrize("number", range(1))
def test_no_triangle_of_a_drawn_body_is_turned_over(sources: tuple[Source, ...], number: int) -> None:
    source = sources[2 * number]
    body = draw_body(source, np.random.default_rng((1, number)))
    if not body.numbers.mastectomy:
        assert is_sound(source.standing, body.standing.vertices, source.faces)
    for skin in (body.standing.vertices, body.supine.vertices):
        assert np.isfinite(skin).all()
        assert face_areas(skin, source.faces).min() > 0.0


def test_a_body_with_turned_triangles_is_refused(source: Source) -> None:
    assert warped_body(source, source.lying[0], replace(Numbers(), navel_up=0.25)) is None


@pytest.mark.parametrize("side", ["L"])
def test_after_a_mastectomy_the_side_is_flat_and_lacks_its_landmarks(source: Source, side: str) -> None:
    body = made(source, replace(Numbers(), mastectomy=side))
    gone = {f"nipple_{side}", f"inframammary_fold_{side}"}
    places = source.landmarks(source.standing)
    nipple, fold = (places[name] for name in sorted(gone, reverse=True))
    region = breast_region(source.standing, source.faces, nipple, fold, float(places["xiphoid"][0]))
    for skin, before in ((body.standing, source.standing), (body.supine, source.lying[0].vertices)):
        assert set(source.names) - set(skin.landmarks) == gone
        flat, round_ = (_off_a_quadric(vertices, region) for vertices in (skin.vertices, before))
        assert flat < 0.5 * round_
    assert body.standing.vertices[region, 2].max() < source.standing[region, 2].max() - 0.015
    np.testing.assert_allclose(body.standing.vertices[~region], source.standing[~region], atol=1e-12)


def _off_a_quadric(vertices: np.ndarray, region: np.ndarray) -> float:
    """m, rms distance in depth of the region from the best quadric over the frontal plane: a chest wall is near one."""
    x, y, z = (vertices[region] - vertices[region].mean(axis=0)).T
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    return float(np.sqrt(np.mean((z - terms @ np.linalg.lstsq(terms, z, rcond=None)[0]) ** 2)))


@pytest.mark.parametrize("above", [-0.04])
def test_a_breast_hangs_as_far_as_its_number_and_its_fold_stays(source: Source, above: float) -> None:
    before = made(source, Numbers()).standing
    body = made(source, replace(Numbers(), nipples_over_folds=(above, 0.015))).standing
    for side, wanted in (("L", above), ("R", 0.015)):
        nipple, fold = (body.landmarks[f"{name}_{side}"] for name in ("nipple", "inframammary_fold"))
        assert nipple[1] - fold[1] == pytest.approx(wanted, abs=0.002)
        assert np.linalg.norm(fold - before.landmarks[f"inframammary_fold_{side}"]) < 0.001
    for name in ("suprasternal_notch", "umbilicus", "acromion_L"):
        assert np.linalg.norm(body.landmarks[name] - before.landmarks[name]) < 0.002, name


def test_a_triangle_folded_against_its_neighbour_is_not_sound_though_a_breast_hangs(source: Source) -> None:
    skin = source.standing
    assert is_sound_hanging(skin, skin, source.faces)
    crumpled = skin + 0.02 * np.random.default_rng(2).standard_normal(skin.shape)
    assert not is_sound_hanging(skin, crumpled, source.faces)
