"""Components of graphs."""

import numpy as np
import pytest

from breastrig.geometry.boundary import components, triangle_components


@pytest.mark.parametrize("order", ["along", "back", "shuffled"])
def test_a_long_chain_is_one_component_whatever_its_numbering(order: str) -> None:
    size = 5000
    nodes = {
        "along": np.arange(size),
        "back": np.arange(size)[::-1],
        "shuffled": np.random.default_rng(1).permutation(size),
    }
    chain = nodes[order]
    count, piece = components(size, chain[:-1], chain[1:])
    assert (count, piece.any()) == (1, False)


def test_they_are_numbered_by_their_smallest_nodes() -> None:
    count, piece = components(6, np.array([5, 4]), np.array([0, 2]))
    assert (count, piece.tolist()) == (4, [0, 1, 2, 3, 2, 0])


def test_triangles_join_their_three_corners() -> None:
    count, piece = triangle_components(np.array([[4, 2, 6], [2, 5, 6], [1, 3, 7]]), 9)
    assert count == 4
    assert piece.tolist() == [0, 1, 2, 1, 2, 2, 2, 1, 3]


def test_loops_at_a_node_join_nothing() -> None:
    assert components(3, np.array([1, 1]), np.array([1, 1]))[0] == 3
