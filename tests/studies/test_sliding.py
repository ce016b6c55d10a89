"""Tissue in a lattice of cubes: derivatives, a column that hangs, a block that slides; bodies made of it."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.sparse import csr_array

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.rotations import exp_so3
from breastrig_studies.sliding.body import NEAR_WALL, RIM, STEP, TUMOURS, Drawn, SlidingBody, drawn, solved
from breastrig_studies.sliding.compare import Carried, learn, part, row
from breastrig_studies.sliding.lattice import CORNERS, DENSITY, Lattice, Net, NotAtRest, Springs, embedded
from breastrig_studies.sliding.wall import LEAST, drawn_wall, footprint
from breastrig_studies.virtual.bodies import VirtualBody, closed
from breastrig_studies.virtual.warped.sources import read_sources

DOWN = np.array([0.0, 0.0, -9.81])
NO_SKIN = Net(csr_array((0, 0)), np.zeros((0, 2), dtype=np.int64), 0.0, 1.0, 1.0)


def boxes(*counts: int) -> tuple[Integers, Array, Integers]:
    """(C, 3) cells from the origin, (N, 3) corners in cells and their (C, 8) numbers."""
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    corners, numbers = np.unique((cells[:, None] + CORNERS.astype(int)).reshape(-1, 3), axis=0, return_inverse=True)
    return cells, corners.astype(np.float64), numbers.reshape(-1, 8)


def block(*counts: int, shear: float = 500.0, along: float = 0.0, skin: bool = False) -> Lattice:
    """Cubes of STEP whose lowest nodes are held, or stand on a wall with N/m³ `along` it."""
    cells, corners, numbers = boxes(*counts)
    nodes, count = STEP * corners, len(corners)
    lowest = np.flatnonzero(corners[:, 2] == 0)
    ground = csr_array((np.ones(len(lowest)), (np.arange(len(lowest)), lowest)), shape=(len(lowest), count))
    area = STEP**2 * counts[0] * counts[1] / len(lowest)
    on = len(lowest) * bool(along)
    up = np.tile([0.0, 0.0, 1.0], (on, 1))
    wall = Springs(ground[:on], up, np.full(on, 1e6 * area), np.full(on, along * area), 0.1)
    edges = numbers[:, [[0, 1], [2, 3], [0, 2]]].reshape(-1, 2)
    net = Net(csr_array(np.eye(count)), edges, 5.0, 1.03, 0.2) if skin else replace(NO_SKIN, at=csr_array((0, count)))
    held = np.zeros(count, dtype=bool) if along else corners[:, 2] == 0
    return Lattice(nodes, numbers, np.ones(len(cells)), np.full(len(cells), shear), 15.0, held, wall, net)


def test_the_forces_are_the_derivative_of_the_energy() -> None:
    soft, rng = block(2, 2, 2, along=1e4, skin=True), np.random.default_rng(2)
    at, way = 1e-3 * rng.normal(size=soft.nodes.shape), rng.normal(size=soft.nodes.shape)
    posed = 1e-3 * rng.normal(size=soft.wall.normals.shape)
    ahead, behind = (soft.energy(at + sign * 1e-6 * way, DOWN, posed)[0] for sign in (1, -1))
    assert (ahead - behind) / 2e-6 == pytest.approx((soft.energy(at, DOWN, posed)[1] * way).sum(), rel=1e-5)


def test_a_soft_column_hangs_as_long_as_theory_has_it() -> None:
    """Free across: a bar under its own weight lengthens by rho g L² / 2E where strains are small."""
    soft, length = block(1, 1, 12, shear=20000.0), 12 * STEP
    moved = soft.at_rest(-DOWN, np.zeros((0, 3)), np.zeros_like(soft.nodes))
    young = 2.0 * 20000.0 * (1.0 + 14.0 / 30.0)
    assert moved[:, 2].max() == pytest.approx(DENSITY * 9.81 * length**2 / (2.0 * young), rel=0.03)


def test_a_block_slides_on_its_wall_as_far_as_its_springs_give_way() -> None:
    soft = block(3, 3, 1, shear=2000.0, along=2e4)
    moved = soft.at_rest(np.array([9.81, 0.0, 0.0]), np.zeros_like(soft.wall.normals), np.zeros_like(soft.nodes))
    ground = soft.nodes[:, 2] == 0
    along = soft.wall.along @ moved[ground, 0]
    assert along == pytest.approx(float(soft.mass.sum()) * 9.81, rel=0.01)  # what holds it is what pulls it
    assert np.abs(moved[ground, 2]).max() < 2e-4


def test_tissue_that_is_too_soft_is_said_not_to_rest() -> None:
    soft = block(1, 1, 12, shear=1.0)
    with pytest.raises(NotAtRest, match=r"does not come to rest|no further down"):
        soft.at_rest(-DOWN, np.zeros((0, 3)), np.zeros_like(soft.nodes))


def test_points_in_and_beside_the_lattice_move_linearly_with_it() -> None:
    cells, corners, numbers = boxes(3, 2, 2)
    points = np.random.default_rng(4).uniform([-0.004, 0.0, 0.0], [0.03, 0.02, 0.024], (50, 3))
    at = embedded(points, np.zeros(3), STEP, cells, numbers)
    slope = np.random.default_rng(5).normal(size=(3, 3))
    np.testing.assert_allclose(at @ (STEP * corners @ slope), points @ slope, atol=1e-12)


@pytest.fixture(scope="module")
def firm() -> tuple[Drawn, SlidingBody]:
    """A firm woman of the stored cohort in coarse cubes, and her motion."""
    source = next(each for each in read_sources(None) if each.name == "cohort_patient_3")
    body = VirtualBody("standing", source.standing, source.landmarks(source.standing), None)
    random = np.random.default_rng(8)
    arms = (np.abs(source.standing[:, 0]) > np.abs(body.landmarks["acromion_L"][0])).astype(np.float64)
    breasts = footprint(body, source.faces)
    wall = drawn_wall(body, source.faces, breasts, arms, random)
    drawn_body = Drawn(body, source.faces, arms, breasts, wall)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("breastrig_studies.sliding.body.STEP", 0.018)
        return drawn_body, solved(drawn_body, replace(drawn(random), fat=400.0, skin=20.0), random)


def test_a_wall_is_possible(firm: tuple[Drawn, SlidingBody]) -> None:
    """As deep as in women at the breastbone, under the skin everywhere, and without the breasts."""
    wall, body = firm[0].wall, firm[0].body
    bone = wall.over(np.array([body.landmarks[name] for name in ("mid_sternum", "xiphoid")]))
    assert bone == pytest.approx(0.0115, abs=0.004)
    skin = body.vertices[firm[0].breasts]
    assert wall.over(skin).min() > 0.9 * LEAST
    nipples = np.array([body.landmarks[f"nipple_{side}"] for side in "LR"])
    assert wall.over(nipples).min() > 0.03
    assert np.ptp(wall.radii[:, len(wall.heights) // 2]) < 0.1  # a trunk, no bulges


def test_breasts_sink_aside_supine_hang_forwards_prone_and_keep_their_volume(firm: tuple[Drawn, SlidingBody]) -> None:
    drawn_body, found = firm
    tips = [int(drawn_body.skin.query(drawn_body.body.landmarks[f"nipple_{side}"][None]).faces[0]) for side in "LR"]
    at = {name: skin[drawn_body.faces[tips]].mean(axis=1) for name, skin in found.skin.items()}
    left, right = at["supine"] - at["prone"]
    assert (left[0], right[0]) == (pytest.approx(-right[0], abs=0.01), pytest.approx(-left[0], abs=0.01))
    assert left[0] > 0.003
    assert max(left[2], right[2]) < -0.009
    assert min(at["supine"][:, 1] - at["standing"][:, 1]) > 0.005  # no weight to the feet
    held = drawn_body.from_breasts(drawn_body.body.vertices) > RIM
    for skin in found.skin.values():
        np.testing.assert_array_equal(skin[held], drawn_body.body.vertices[held])
    volumes = [trimesh.Trimesh(*closed(skin, drawn_body.faces), process=False).volume for skin in found.skin.values()]
    assert np.ptp(volumes) < 7e-5  # a fortieth of what moves; the rim goes up with the arm


def test_tumours_are_tissue_half_of_it_near_the_wall(firm: tuple[Drawn, SlidingBody]) -> None:
    found = firm[1]
    assert len(found.radii) == 2 * TUMOURS
    assert (found.over_wall < NEAR_WALL).sum() >= TUMOURS
    moved = np.linalg.norm(found.tumours["supine"] - found.tumours["prone"], axis=1)
    near = found.over_wall < NEAR_WALL
    assert moved[near].mean() < 0.8 * moved[~near].mean()
    assert not np.array_equal(found.wall["prone"], found.wall["standing"])  # goes up with the arm


def motion(name: str, group: str, seed: int) -> Carried:
    """Ten tumours and forty nodes that stay the more with the breastbone the nearer they are to the wall."""
    rng = np.random.default_rng(seed)
    free, fast, height = 0.02 * rng.normal(size=(50, 3)), 0.02 * rng.normal(size=(50, 3)), rng.uniform(0.0, 0.04, 50)
    true = free + (0.8 * np.exp(-height / 0.012))[:, None] * (fast - free)
    side, axes = np.where(rng.random(50) < 0.5, 1.0, -1.0), exp_so3(rng.normal(size=3))
    ways = {"map": free, "held": true}
    return Carried(name, group, 10, true, ways, fast, height, rng.random(50), axes, side, np.full(50, 0.005))


def test_what_development_bodies_teach_is_used_on_the_others() -> None:
    bodies = [motion(f"{k}", ("development", "validation")[k == 3], k) for k in range(4)]
    learn(bodies)
    by_way = {way: row([part(bodies[3], way)]) for way in bodies[3].ways}
    assert by_way["held"] == {"tumours": 10, "mean_mm": 0.0, "p95_mm": 0.0, "held": 1.0} | {
        "near_wall": int((bodies[3].height[:10] < 0.015).sum()),
        "near_mean_mm": 0.0,
        "near_held": 1.0,
    }
    means = [float(by_way[way]["mean_mm"]) for way in ("field_on_wall", "field", "map")]
    assert means[0] < 0.2
    assert means[0] < means[1] < means[2]
