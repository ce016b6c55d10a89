"""The skin layer's linear systems, banded or sparse, against a dense solution."""

import numpy as np
import pytest
from helpers.surfaces import sphere

from breastrig.fitting.body import refine
from breastrig.fitting.body.refine import _Systems, stiffness_and_area


@pytest.mark.parametrize("band_work", [refine.BAND_WORK, 0.0])
def test_a_layer_is_what_a_dense_solution_gives(band_work: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refine, "BAND_WORK", band_work)
    rng = np.random.default_rng(8)
    vertices, faces = sphere(0.1, 2)
    shuffled = rng.permutation(len(vertices))
    systems = _Systems(*stiffness_and_area(vertices[np.argsort(shuffled)], shuffled[faces]))
    weight, flat, right = rng.uniform(1e5, 2e5, len(vertices)), rng.uniform(1e3, 2e3, len(vertices)), vertices[:, 0]
    wanted = np.linalg.solve(systems.system(weight, flat).toarray(), right)
    np.testing.assert_allclose(systems.solved(weight, flat, right), wanted, rtol=1e-8, atol=1e-12)
