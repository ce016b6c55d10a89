"""Soft bodies at rest: derivatives, a bar that hangs by its end, and back to the shape without gravity."""

import numpy as np
import pytest
from scipy.optimize import brentq
from skfem import MeshTet

from breastrig.core.arrays import Array, Integers
from breastrig_studies.gravity.statics import SoftBody, Tissue

DOWN = np.array([0.0, 0.0, -9.81])


def bar(width: float, height: float, across: int, along: int) -> tuple[Array, Integers]:
    """A bar from z = 0 up, of positive tetrahedra."""
    mesh = MeshTet.init_tensor(
        np.linspace(0, width, across), np.linspace(0, width, across), np.linspace(0, height, along)
    )
    points, tetrahedra = mesh.p.T, mesh.t.T
    inverted = np.linalg.det(points[tetrahedra[:, 1:]] - points[tetrahedra[:, :1]]) < 0.0
    return points, np.where(inverted[:, None], tetrahedra[:, [0, 2, 1, 3]], tetrahedra)


def body(points: Array, tetrahedra: Integers, shear: float, skin: float = 0.0, held: float = 0.0) -> SoftBody:
    """Held below `held`, or by its upper end; all of its side has skin."""
    mesh = MeshTet(points.T.copy(), tetrahedra.T.copy())
    sides = mesh.facets.T[mesh.boundary_facets()] if skin else np.zeros((0, 3), dtype=np.int64)
    top = points[:, 2] > points[:, 2].max() - 1e-9
    stays = points[:, 2] < held if held else top
    return SoftBody(points, tetrahedra, sides, stays, Tissue(np.full(len(tetrahedra), shear), skin))


def test_the_stiffness_is_the_derivative_of_the_forces_and_these_of_the_energy() -> None:
    soft = body(*bar(0.02, 0.04, 2, 3), 500.0, skin=12.0)
    rng = np.random.default_rng(3)
    gravity, step = np.array([1.0, -2.0, 9.81]), 1e-6
    at, way = 3e-4 * rng.normal(size=soft.points.shape), rng.normal(size=soft.points.shape)
    ahead, behind = (soft.energy(at + sign * step * way, gravity) for sign in (1, -1))
    assert (ahead - behind) / (2 * step) == pytest.approx((soft.forces(at, gravity) * way).sum(), rel=1e-6)
    free = soft.free
    way[~free] = 0.0
    ahead, behind = (soft.forces(at + sign * step * way, gravity)[free] for sign in (1, -1))
    change = (ahead - behind) / (2 * step)
    assert soft.stiffness(at) @ way[free].ravel() == pytest.approx(change.ravel(), abs=1e-5 * np.abs(change).max())


def test_a_bar_that_hangs_is_as_long_as_theory_has_it() -> None:
    length, shear, density = 0.1, 600.0, 1000.0
    points, tetrahedra = bar(0.003, length, 2, 31)
    soft = body(points, tetrahedra, shear)
    moved, free = (
        soft.at_rest(DOWN)[:, 2],
        0.9 * length,
    )  # above, the end that is held cannot become thinner
    low, high = (moved[np.abs(points[:, 2] - height) < 1e-9].mean() for height in (0.0, free))

    def stretch(pull: float) -> float:
        """Along a bar under the nominal stress `pull`, free across: mu (a - 1/a) + lame (J - 1) J / a."""
        lame = 15.0 * shear

        def across(along: float) -> float:
            return brentq(lambda b: shear * (b - 1 / b) + lame * (along * b * b - 1) * along * b, 0.3, 1.5, xtol=1e-14)

        def missing(along: float) -> float:
            b = across(along)
            return shear * (along - 1 / along) + lame * (along * b * b - 1) * b * b - pull

        return brentq(missing, 0.9, 6.0, xtol=1e-12)

    places = (np.arange(400) + 0.5) / 400 * free  # above the lower end
    wanted = sum(stretch(density * 9.81 * place) - 1.0 for place in places) * free / 400
    assert wanted > 0.25 * length
    assert high - low == pytest.approx(wanted, rel=0.02)


def test_a_body_that_rests_in_its_shape_goes_where_the_same_body_without_stress_goes() -> None:
    """What sinks from its unloaded shape is stressed in the sunken one: then turned, it is where the first one is."""
    points, tetrahedra = bar(0.06, 0.04, 5, 5)
    sideways, over = np.array([0.0, -9.81, 0.0]), np.array([0.0, 0.0, 9.81])
    free = body(points, tetrahedra, 600.0, skin=3.0, held=1e-6)
    sunk = points + free.at_rest(sideways)
    mesh = MeshTet(points.T.copy(), tetrahedra.T.copy())
    tissue = Tissue(np.full(len(tetrahedra), 600.0), 3.0)
    rests = SoftBody(sunk, tetrahedra, mesh.facets.T[mesh.boundary_facets()], points[:, 2] < 1e-6, tissue).resting(
        sideways
    )
    assert np.abs(rests.at_rest(sideways, None, sideways)).max() < 1e-4
    for way in (np.zeros(3), over):
        wanted = points + free.at_rest(way) - sunk
        gap = np.linalg.norm(rests.at_rest(way, None, sideways) - wanted, axis=1)
        assert gap.max() < 0.1 * np.linalg.norm(wanted, axis=1).max()
