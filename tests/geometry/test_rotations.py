"""Rotations by their mathematical properties."""

import numpy as np

from breastrig.geometry.rotations import (
    exp_so3,
    hat,
    log_so3,
    quaternion_from_rotation,
    quaternion_product,
    right_jacobian_inverse,
    rotation_from_quaternion,
)


def vectors(rng: np.random.Generator) -> np.ndarray:
    directions = rng.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return directions * np.concatenate([np.zeros(1), np.geomspace(1e-12, np.pi - 1e-6, 199)])[:, None]


def test_exp_gives_rotations_and_log_takes_them_back(rng: np.random.Generator) -> None:
    v = vectors(rng)
    rotations = exp_so3(v)
    np.testing.assert_allclose(
        rotations @ rotations.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (200, 3, 3)), atol=1e-14
    )
    np.testing.assert_allclose(np.linalg.det(rotations), 1.0, atol=1e-14)
    np.testing.assert_allclose(log_so3(rotations), v, atol=1e-9)


def test_quaternions_are_unit_and_say_the_same_rotation(rng: np.random.Generator) -> None:
    rotations = exp_so3(vectors(rng))
    quaternions = quaternion_from_rotation(rotations)
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(rotation_from_quaternion(quaternions), rotations, atol=1e-12)


def test_the_product_of_quaternions_is_that_of_their_rotations_and_vectors_have_no_real_part(
    rng: np.random.Generator,
) -> None:
    a, b = exp_so3(vectors(rng)), exp_so3(vectors(rng)[::-1])
    p, q = quaternion_from_rotation(a), quaternion_from_rotation(b)
    np.testing.assert_allclose(rotation_from_quaternion(quaternion_product(p, q)), a @ b, atol=1e-12)
    v = rng.normal(size=(200, 3))
    pure = np.concatenate([v, np.zeros((200, 1))], axis=1)
    np.testing.assert_array_equal(quaternion_product(v, q), quaternion_product(pure, q))
    np.testing.assert_array_equal(quaternion_product(p, v), quaternion_product(p, pure))


def test_hat_is_the_cross_product(rng: np.random.Generator) -> None:
    a, b = rng.normal(size=(2, 50, 3))
    np.testing.assert_allclose(np.einsum("mij,mj->mi", hat(a), b), np.cross(a, b), atol=1e-14)


def test_the_right_jacobian_moves_the_logarithm(rng: np.random.Generator) -> None:
    v = rng.normal(size=(50, 3))
    step = 1e-6 * rng.normal(size=(50, 3))
    rotations = exp_so3(v)
    moved = log_so3(rotations @ exp_so3(step)) - log_so3(rotations)
    np.testing.assert_allclose(
        moved, np.einsum("mij,mj->mi", right_jacobian_inverse(log_so3(rotations)), step), atol=1e-10
    )
