"""Rotations as (…, 3, 3) matrices, rotation vectors in radians and quaternions x y z w (glTF's order)."""

import numpy as np

from breastrig.core.arrays import Array


def hat(vectors: Array) -> Array:
    """(…, 3) -> (…, 3, 3) with hat(a) @ b = a × b."""
    result = np.zeros((*vectors.shape[:-1], 3, 3))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    result[..., 0, 1], result[..., 0, 2] = -z, y
    result[..., 1, 0], result[..., 1, 2] = z, -x
    result[..., 2, 0], result[..., 2, 1] = -y, x
    return result


def exp_so3(vectors: Array) -> Array:
    """(…, 3) rad -> (…, 3, 3): Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    cross = hat(vectors)
    small = angle < 1e-6
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 1.0 - angle**2 / 6.0, np.sin(safe) / safe)
    second = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    return np.asarray(np.eye(3) + first * cross + second * (cross @ cross))


def log_so3(rotations: Array) -> Array:
    """(…, 3, 3) -> (…, 3) rad, angle in [0, π]; goes through the quaternion, which is stable near 0 and π."""
    quaternion = quaternion_from_rotation(rotations)
    sine = np.linalg.norm(quaternion[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, quaternion[..., 3:])
    factor = np.where(sine < 1e-9, 2.0, angle / np.where(sine < 1e-9, 1.0, sine))
    return np.asarray(factor * quaternion[..., :3])


def right_jacobian_inverse(vectors: Array) -> Array:
    """(…, 3) rad -> (…, 3, 3): log(R exp(d)) = log R + J d + O(d²), with `vectors` = log R.

    Solà, Deray, Atchuthan: A micro Lie theory for state estimation in robotics (2018), equation 144.
    """
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    cross = hat(vectors)
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    factor = np.where(
        small, 1.0 / 12.0 + angle**2 / 720.0, 1.0 / safe**2 - (1.0 + np.cos(safe)) / (2.0 * safe * np.sin(safe))
    )
    return np.asarray(np.eye(3) + 0.5 * cross + factor * (cross @ cross))


def quaternion_from_rotation(rotations: Array) -> Array:
    """(…, 3, 3) -> (…, 4) unit quaternion x y z w with w >= 0 (Shepperd's method)."""
    m = rotations
    trace = m[..., 0, 0] + m[..., 1, 1] + m[..., 2, 2]
    if (trace > 0.0).all():  # by less than 120 degrees, as joints turn: one of the four ways is good for all
        own = np.stack([m[..., i, j] - m[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0))] + [1.0 + trace], axis=-1)
        return np.asarray(own / np.linalg.norm(own, axis=-1, keepdims=True))
    xx, yy, zz = (1.0 + 2.0 * m[..., i, i] - trace for i in range(3))
    xy, xz, yz = (m[..., i, j] + m[..., j, i] for i, j in ((0, 1), (0, 2), (1, 2)))
    wx, wy, wz = (m[..., i, j] - m[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0)))
    rows = [[xx, xy, xz, wx], [xy, yy, yz, wy], [xz, yz, zz, wz], [wx, wy, wz, 1.0 + trace]]
    candidates = np.stack([np.stack(row, -1) for row in rows], -2)
    norms = np.linalg.norm(candidates, axis=-1)
    best = np.take_along_axis(candidates, norms.argmax(axis=-1)[..., None, None], axis=-2)[..., 0, :]
    best = best / np.linalg.norm(best, axis=-1, keepdims=True)
    return np.asarray(np.where(best[..., 3:] < 0, -best, best))


def rotation_from_quaternion(quaternions: Array) -> Array:
    """(…, 4) x y z w -> (…, 3, 3)."""
    q = quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True)
    cross = hat(q[..., :3])
    return np.asarray(np.eye(3) + 2.0 * q[..., 3:, None] * cross + 2.0 * (cross @ cross))


def quaternion_product(left: Array, right: Array) -> Array:
    """(…, 4) x y z w of (…, 4), or of (…, 3) vectors, whose w is 0."""
    (a, v), (b, u) = ((each[..., 3:] if each.shape[-1] == 4 else 0.0, each[..., :3]) for each in (left, right))
    real = a * b - (v * u).sum(axis=-1, keepdims=True)
    return np.concatenate([a * u + b * v + np.cross(v, u), real], axis=-1)
