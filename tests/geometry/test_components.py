"""Components of graphs, against SciPy's."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from breastrig.geometry.components import component_roots, components, triangle_components


@pytest.mark.parametrize(("nodes", "edges"), [(1, 0), (10, 4), (500, 150), (500, 499), (2000, 9000)])
def test_they_are_those_of_scipy(nodes: int, edges: int) -> None:
    rng = np.random.default_rng(nodes + edges)
    first, second = rng.integers(0, nodes, (2, edges))
    count, piece = components(nodes, first, second)
    wanted, label = connected_components(coo_array((np.ones(edges), (first, second)), shape=(nodes, nodes)), False)
    assert count == wanted
    np.testing.assert_array_equal(piece, label)


@pytest.mark.parametrize("order", ["along", "back", "shuffled"])
def test_a_long_chain_is_one_component_whatever_its_numbering(order: str) -> None:
    size = 5000
    nodes = {
        "along": np.arange(size),
        "back": np.arange(size)[::-1],
        "shuffled": np.random.default_rng(1).permutation(size),
    }
    chain = nodes[order]
    assert not component_roots(size, chain[:-1], chain[1:]).any()


def test_triangles_join_their_three_corners() -> None:
    count, piece = triangle_components(np.array([[4, 2, 6], [2, 5, 6], [1, 3, 7]]), 9)
    assert count == 4
    assert piece.tolist() == [0, 1, 2, 1, 2, 2, 2, 1, 3]


def test_loops_at_a_node_join_nothing() -> None:
    assert components(3, np.array([1, 1]), np.array([1, 1]))[0] == 3
