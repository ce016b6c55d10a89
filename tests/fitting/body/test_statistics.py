"""What is known of bodies: of this rig only, symmetric, and a true covariance."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.cohort_posterior import mirrored_places
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig_studies.bodies.body_statistics import KnownBody, document, mixed, statistics
from breastrig_studies.studies.sensitivity import with_shapes


def test_the_torsos_statistics_prefer_no_side(torso: Rig) -> None:
    known = body_statistics(torso)
    other = mirrored_places(torso)
    assert sorted(other.tolist()) == list(range(len(other)))
    np.testing.assert_allclose(known.mean_scales, known.mean_scales[other[: len(known.mean_scales)]], atol=1e-3)
    size = np.abs(known.covariance).max()
    np.testing.assert_allclose(known.covariance, known.covariance[other][:, other], atol=2e-3 * size)
    assert np.linalg.eigvalsh(known.covariance).min() > -1e-9 * size


def test_bodies_are_as_deep_as_they_are_wide(torso: Rig) -> None:
    """What the prior is there for: an unseen back follows from the seen width."""
    known = body_statistics(torso)
    chest = 3 * torso.bone_names.index("lower_thorax")
    width, depth = chest, chest + 2
    deviation = np.sqrt(np.diag(known.covariance))
    assert known.covariance[width, depth] / (deviation[width] * deviation[depth]) > 0.2


def test_another_rig_has_none(torso: Rig) -> None:
    bones = (replace(torso.bones[0], name="other"), *torso.bones[1:])
    assert body_statistics(replace(torso, bones=bones)) is None
    assert body_statistics(replace(torso, known={})) is None
    shapes = (replace(torso.shapes[0], name="other"), *torso.shapes[1:])
    assert body_statistics(replace(torso, shapes=shapes)) is None


def test_a_rig_with_some_of_the_shapes_has_their_part(torso: Rig) -> None:
    whole = body_statistics(torso)
    names = torso.shape_names[3:9]
    part = body_statistics(with_shapes(torso, names))
    scales = 3 * len(torso.bones)
    kept = [*range(scales), *range(scales + 3, scales + 9)]
    np.testing.assert_allclose(part.covariance, whole.covariance[np.ix_(kept, kept)], rtol=1e-12, atol=1e-15)


def test_the_covariance_is_that_of_the_bodies_within_their_stance(torso: Rig) -> None:
    rng = np.random.default_rng(2)
    rest = rest_parameters(torso)

    def body(stance: str, woman: str) -> KnownBody:
        size = 1.1 + 0.1 * rng.standard_normal()
        lying = 0.5 if stance == "supine" else 0.0
        x = replace(rest, scales=np.full_like(rest.scales, size), weights=np.full_like(rest.weights, lying))
        return KnownBody(woman, stance, x)

    bodies = [body(stance, f"{k}") for stance in ("standing", "supine") for k in range(40)]
    seen_often = [*bodies, *[bodies[0]] * 7, *[bodies[40]] * 7]
    known = statistics(torso, seen_often)
    written = document(torso, known)
    factors = np.array(written["factors"])
    covariance = factors.T @ factors
    scales = 3 * len(torso.bones)
    sizes = np.array([each.parameters.scales[0, 0] for each in bodies])
    assert written["mean_scales"] == pytest.approx(np.full(scales, sizes.mean()), abs=1e-4)
    within = 0.5 * (sizes[:40].var() + sizes[40:].var())
    np.testing.assert_allclose(covariance[:scales, :scales], within, rtol=0.01)
    np.testing.assert_allclose(covariance[scales:, scales:], 0.0, atol=1e-9)
    np.testing.assert_allclose(mixed(known, known).covariance, known.covariance)
