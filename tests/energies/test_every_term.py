"""Every residual term and constraint, against finite differences, at random poses of a toy rig."""

import pkgutil
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.gradient_check import assert_jacobian_matches_finite_differences
from helpers.random_pose import random_parameters

import breastrig.energies
from breastrig.core.stances import split_side
from breastrig.correspondence.match import Correspondences
from breastrig.energies.body_prior import BodyPrior
from breastrig.energies.folding import Folding
from breastrig.energies.joint_limits import JointLimits
from breastrig.energies.joint_rest import JointRest
from breastrig.energies.landmarks import LandmarkObservation, Landmarks
from breastrig.energies.modes import Modes
from breastrig.energies.point_to_plane import PointToPlane
from breastrig.energies.point_to_point import PointToPoint
from breastrig.energies.scale_prior import ScalePrior
from breastrig.energies.shape_prior import ShapePrior
from breastrig.energies.symmetry import Symmetry
from breastrig.energies.table_contact import TableContact
from breastrig.geometry.plane import Plane
from breastrig.least_squares.newton import assemble, wide
from breastrig.rig.joints import Joints
from breastrig.rig.model import LEAST_GAP, Rig
from breastrig.rig.modes import mode_count
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.state import BodyState


def matches(rig: Rig, rng: np.random.Generator) -> Correspondences:
    chosen = rng.choice(len(rig.template), 40, replace=False)
    normals = rng.normal(size=(40, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Correspondences(chosen, rig.template[chosen] + 0.02 * rng.normal(size=(40, 3)), normals, np.zeros(40))


def random_state(rig: Rig, rng: np.random.Generator) -> BodyState:
    return BodyState(rig, replace(random_parameters(rig, rng), modes=rng.normal(size=mode_count(rig))))


def tight_joints(rig: Rig) -> Joints:
    """Joints that a random pose turns beyond their limit, but for the first."""
    limits = [3.0] + [0.05] * (len(rig.joints) - 1)
    return Joints(rig, tuple(replace(j, rotation_limit=limit) for j, limit in zip(rig.joints, limits, strict=True)))


def random_body(rig: Rig, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A mean and a covariance in which everything goes with everything."""
    size = 3 * len(rig.bones) + len(rig.shapes)
    factors = rng.normal(size=(size, size))
    return rng.normal(size=size), factors @ factors.T / size + np.eye(size)


def observations(rig: Rig, rng: np.random.Generator) -> list[LandmarkObservation]:
    """Of all landmarks, anywhere, with errors in which all axes go with each other."""
    factors = 0.005 * rng.normal(size=(len(rig.landmarks), 3, 3))
    return [
        LandmarkObservation(name, rng.normal(size=3), factor @ factor.T + 1e-6 * np.eye(3))
        for name, factor in zip(rig.landmark_names, factors, strict=True)
    ]


TERMS: dict[str, Callable[[Rig, np.random.Generator], Any]] = {
    "point_to_plane": lambda rig, rng: PointToPlane(rig, matches(rig, rng), rng.uniform(0.1, 1, 40), 0.003),
    "point_to_point": lambda rig, rng: PointToPoint(rig, matches(rig, rng), rng.uniform(0.1, 1, 40), 0.01),
    "landmarks": lambda rig, rng: Landmarks(rig, observations(rig, rng), rng.uniform(0.1, 1, len(rig.landmarks)), 2.0),
    "scale_prior": lambda rig, _: ScalePrior(rig, 0.1, 0.05),
    "shape_prior": lambda rig, rng: ShapePrior(rng.uniform(0.1, 1, len(rig.shapes)), rng.normal(size=len(rig.shapes))),
    "symmetry": lambda rig, _: Symmetry(rig, 0.5, 0.02),
    "joint_rest": lambda rig, rng: JointRest(Joints(rig, rig.joints, 0.2 * rng.normal(size=(len(rig.joints), 3)))),
    "body_prior": lambda rig, rng: BodyPrior(rig, *random_body(rig, rng)),
    "table_contact": lambda rig, rng: TableContact(
        rig,
        Plane(np.array([0.6, 0.0, 0.8]), 0.01),
        (np.arange(3), np.arange(5, len(rig.template), 7)),
        rng.uniform(0.0, 0.05, 2),
        0.012,
        0.005,
        0.004,
    ),
    "folding": lambda rig, _: Folding(rig, 1.02, 0.1),
    "joint_limits": lambda rig, _: JointLimits(tight_joints(rig), 0.03),
    "modes": lambda rig, _: Modes(rig, 0.5),
}
MODES = "landmarks = {names}\nwidth = 0.1\nalong = 0.01\nacross = 0.005\nsymmetry = 0.5"


def rigs(rig: Rig, term: str) -> tuple[Rig, ...]:
    """Without smooth modes, and with them: most terms know nothing of these."""
    flexible = replace(rig, known={"modes.toml": MODES.format(names=[split_side(n)[0] for n in rig.landmark_names])})
    return (flexible,) if term == "modes" else (rig, flexible)


def test_point_to_point_can_stand_for_point_to_plane_too(toy_rig: Rig) -> None:
    rng = np.random.default_rng(1)
    found, weights, x = matches(toy_rig, rng), rng.uniform(0.1, 1, 40), random_state(toy_rig, rng)
    both = PointToPoint(toy_rig, found, weights, 0.01, 0.003)
    assert_jacobian_matches_finite_differences(both, toy_rig, x)
    apart = [PointToPoint(toy_rig, found, weights, 0.01), PointToPlane(toy_rig, found, weights, 0.003)]
    lin, lins = both.linearise(x), [term.linearise(x) for term in apart]
    hessian = sum(part.jacobian.T @ part.jacobian for part in lins)
    np.testing.assert_allclose(lin.jacobian.T @ lin.jacobian, hessian, rtol=1e-9, atol=1e-9 * np.abs(hessian).max())
    assert lin.residual @ lin.residual == pytest.approx(sum(part.residual @ part.residual for part in lins))


def test_no_term_is_forgotten() -> None:
    files = {module.name for module in pkgutil.iter_modules(breastrig.energies.__path__)}
    assert files - set(TERMS) == set(), "add the term to TERMS above, with any sizes: it is then checked as all are"
    assert set(TERMS) - files == set(), "take it from TERMS above: there is no such file in energies/"


@pytest.mark.parametrize("name", TERMS)
@pytest.mark.parametrize("seed", range(3))
def test_the_jacobian_matches_finite_differences(name: str, seed: int, toy_rig: Rig) -> None:
    for rig in rigs(toy_rig, name):
        rng = np.random.default_rng(seed)
        term = TERMS[name](rig, rng)
        assert_jacobian_matches_finite_differences(term, rig, random_state(rig, rng))


@pytest.mark.parametrize("name", TERMS)
def test_the_normal_equations_are_those_of_the_jacobian(name: str, toy_rig: Rig) -> None:
    """However the solver forms them: a structured term gives its own."""
    rng = np.random.default_rng(6)
    for rig in rigs(toy_rig, name):
        term, state = TERMS[name](rig, rng), random_state(rig, rng)
        lin, found = term.linearise(state), assemble([term], state)
        slope = wide(lin.jacobian, state.dof)
        hessian, gradient = slope.T @ slope, slope.T @ lin.residual
        np.testing.assert_allclose(found.hessian, hessian, rtol=0, atol=1e-10 * np.abs(hessian).max())
        np.testing.assert_allclose(found.gradient, gradient, rtol=0, atol=1e-10 * np.abs(gradient).max())
        assert found.energy == pytest.approx(0.5 * lin.residual @ lin.residual, rel=1e-12)


@pytest.mark.parametrize("name", ["shape_prior", "scale_prior", "symmetry", "joint_rest", "joint_limits", "folding"])
def test_a_rig_at_rest_costs_nothing(name: str, toy_rig: Rig) -> None:
    rest = BodyState(toy_rig, rest_parameters(toy_rig))
    term = {
        "shape_prior": ShapePrior(np.ones(len(toy_rig.shapes)), np.zeros(len(toy_rig.shapes))),
        "scale_prior": ScalePrior(toy_rig, 0.1, 0.05),
        "symmetry": Symmetry(toy_rig, 0.5, 0.02),
        "joint_rest": JointRest(Joints(toy_rig, toy_rig.joints)),
        "joint_limits": JointLimits(Joints(toy_rig, toy_rig.joints), 0.03),
        "folding": Folding(toy_rig, 0.3, 0.1),
    }[name]
    np.testing.assert_allclose(term.residual(rest), 0.0, atol=1e-12)


def test_a_rigid_move_of_the_whole_rig_strains_no_joint(toy_rig: Rig) -> None:
    rng = np.random.default_rng(4)
    rest = rest_parameters(toy_rig)
    turned = random_parameters(toy_rig, rng).rotations[0]
    moved = BodyState(toy_rig, rest.moved(turned, rng.normal(size=3)))
    np.testing.assert_allclose(JointRest(Joints(toy_rig, toy_rig.joints)).residual(moved), 0.0, atol=1e-9)


def test_a_joint_that_gives_nothing_gives_the_least_that_can_be_solved(toy_rig: Rig) -> None:
    rng = np.random.default_rng(4)
    stiff = tuple(replace(joint, translation_sigma=0.0) for joint in toy_rig.joints)
    least = tuple(replace(joint, translation_sigma=LEAST_GAP) for joint in toy_rig.joints)
    x = random_state(toy_rig, rng)
    found, known = (JointRest(Joints(toy_rig, joints)).residual(x) for joints in (stiff, least))
    assert np.isfinite(found).all()
    np.testing.assert_array_equal(found, known)


def test_a_joint_inside_its_limit_costs_nothing_and_one_beyond_it_does(toy_rig: Rig) -> None:
    joints = tight_joints(toy_rig)
    x = random_state(toy_rig, np.random.default_rng(5))
    residual = JointLimits(joints, 0.03).residual(x)
    angles = np.linalg.norm(x.motion(joints).turn, axis=1)
    np.testing.assert_allclose(residual[1:], (angles[1:] - 0.05) / 0.03, atol=1e-12)
    assert residual[0] == 0.0


def test_an_observation_pulls_only_where_it_knows(toy_rig: Rig) -> None:
    """The squared residual is the Mahalanobis distance: next to nothing along an unknown axis."""
    x = random_state(toy_rig, np.random.default_rng(9))
    points = toy_rig.landmark_points((toy_rig.landmark_names[0],))
    along = np.array([0.6, 0.8, 0.0])
    covariance = 0.003**2 * np.eye(3) + np.outer(along, along)
    target = points.positions(x.posed.vertices, toy_rig.faces) - 0.01 * along
    residual = Landmarks(toy_rig, [LandmarkObservation(toy_rig.landmark_names[0], target[0], covariance)]).residual(x)
    assert residual @ residual == pytest.approx(0.01**2 / (1.0 + 0.003**2), rel=1e-9)
