"""Sparse matrices over a surface, solved as a band: what a dense solution gives."""

import numpy as np
import pytest
from helpers.surfaces import sphere
from scipy.sparse import block_diag, csc_array

from breastrig.core.scipy_parts import Factor, LinAlgError
from breastrig.fitting import refine
from breastrig.fitting.refine import _Systems, stiffness_and_area
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.banded_cholesky import BandedCholesky, banded_cholesky, wave_order


def over_a_ball(rng: np.random.Generator, level: int = 2) -> csc_array:
    vertices, faces = sphere(0.1, level)
    shuffled = rng.permutation(len(vertices))
    stiffness, area = stiffness_and_area(vertices[np.argsort(shuffled)], shuffled[faces])
    matrix = csc_array(stiffness + csc_array(np.diag(rng.uniform(0.5, 2.0, len(area)))))
    matrix.sort_indices()
    return matrix


def test_it_solves_as_a_dense_solution_does() -> None:
    rng = np.random.default_rng(8)
    matrix = over_a_ball(rng)
    banded, right = BandedCholesky(matrix.indptr, matrix.indices), rng.normal(size=matrix.shape[0])
    for scale in (1.0, 3.0):  # other entries at the same places
        wanted = np.linalg.solve(scale * matrix.toarray(), right)
        np.testing.assert_allclose(banded.solved(scale * matrix.data, right), wanted, rtol=1e-10)


def test_the_order_has_every_unknown_once_and_makes_a_narrow_band() -> None:
    matrix = over_a_ball(np.random.default_rng(9), level=4)
    count = matrix.shape[0]
    np.testing.assert_array_equal(np.sort(wave_order(matrix.indptr, matrix.indices)), np.arange(count))
    assert BandedCholesky(matrix.indptr, matrix.indices).band < 5 * np.sqrt(count)


def test_parts_that_are_not_connected_are_all_solved() -> None:
    rng = np.random.default_rng(10)
    matrix = csc_array(block_diag([over_a_ball(rng), np.array([[2.0]]), over_a_ball(rng)], format="csc"))
    right = rng.normal(size=matrix.shape[0])
    solved = BandedCholesky(matrix.indptr, matrix.indices).solved(matrix.data, right)
    np.testing.assert_allclose(solved, np.linalg.solve(matrix.toarray(), right), rtol=1e-10)


def test_surfaces_of_one_model_share_the_order() -> None:
    rig = read_rig(default_rig_path())
    one, other = (_Systems(*stiffness_and_area(places, rig.faces)) for places in (rig.template, 1.1 * rig.template))
    assert one._banded is other._banded
    ball = over_a_ball(np.random.default_rng(12))
    assert banded_cholesky(ball.indptr, ball.indices) is not one._banded


def test_a_matrix_that_is_not_positive_definite_is_refused() -> None:
    matrix = csc_array(np.array([[1.0, 2.0], [2.0, 1.0]]))
    with pytest.raises(LinAlgError, match="not positive definite"):
        BandedCholesky(matrix.indptr, matrix.indices).solved(matrix.data, np.ones(2))
    empty = csc_array((0, 0))
    assert BandedCholesky(empty.indptr, empty.indices).solved(empty.data, np.zeros(0)).shape == (0,)


def test_the_layer_of_the_torso_is_solved_as_a_band_and_a_wide_one_by_superlu(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = read_rig(default_rig_path())
    stiffness, area = stiffness_and_area(rig.template, rig.faces)
    systems = _Systems(stiffness, area)
    rng = np.random.default_rng(11)
    weight, flat, right = rng.uniform(1e3, 1e6, (3, len(area)))
    by_superlu: list[int] = []
    whole = refine.symmetric_factor

    def noted(matrix: csc_array) -> Factor:
        by_superlu.append(matrix.shape[0])
        return whole(matrix)

    monkeypatch.setattr(refine, "symmetric_factor", noted)
    narrow = systems.solved(weight, flat, right)
    assert not by_superlu
    monkeypatch.setattr("breastrig.least_squares.banded_cholesky.WORK", 1e6)
    wide = systems.solved(weight, flat, right)
    assert by_superlu == [len(area)]
    np.testing.assert_allclose(narrow, wide, rtol=1e-9, atol=1e-12 * np.abs(wide).max())
