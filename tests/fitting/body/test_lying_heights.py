"""How high parts of lying bodies are: of this rig only, no side preferred, and the back told by the rest."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.evaluation.lying_heights import learnt
from breastrig.fitting.body.lying_heights import LyingHeights, lying_heights, means_of, parts_of
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def test_the_parts_are_alike_on_both_sides_and_those_of_the_back_are_all_of_it(torso: Rig) -> None:
    parts = parts_of(torso)
    for part in parts.values():
        np.testing.assert_array_equal(np.sort(torso.mirror_vertices[part]), np.sort(part))
    known = lying_heights(torso)
    assert known is not None
    np.testing.assert_array_equal(np.sort(np.concatenate(known.back)), np.sort(torso.regions["back"]))
    seen = np.concatenate([part for part, of_back in zip(known.parts, known.of_back, strict=True) if not of_back])
    assert not np.isin(seen, torso.regions["back"]).any()


def test_of_another_rig_nothing_is_known(torso: Rig) -> None:
    assert lying_heights(replace(torso, name="somebody")) is None
    regions = {name: part for name, part in torso.regions.items() if name != "back"}
    assert lying_heights(replace(torso, regions=regions)) is None


def test_the_back_is_where_the_rest_says(torso: Rig) -> None:
    """Bodies that lie higher as a whole, and nothing else: then seen parts tell the back to the last tenth."""
    parts = parts_of(torso)
    bodies = [np.full(len(parts), height) for height in (0.03, 0.05, 0.07)]
    document = learnt(torso, {str(k): [body] for k, body in enumerate(bodies)})
    factors = 1e-3 * np.array(document["factors_mm"])
    known = lying_heights(torso)
    assert known is not None
    known = LyingHeights(known.parts, known.of_back, 1e-3 * np.array(document["mean_mm"]), factors.T @ factors)
    mean, covariance = known.back_given(np.full(len(torso.template), 0.09), 1e-4)
    assert mean == pytest.approx(0.09, abs=1e-4)
    assert np.sqrt(np.diag(covariance)) == pytest.approx(1e-4, rel=0.1)
    middle, _ = known.back_given(np.full(len(torso.template), 0.05), 1e-4)
    assert middle == pytest.approx(0.05, abs=1e-6)


def test_every_woman_counts_alike(torso: Rig) -> None:
    low, high = (np.full(len(parts_of(torso)), height) for height in (0.02, 0.04))
    document = learnt(torso, {"one": [low] * 3, "other": [high]})
    assert np.array(document["mean_mm"]) == pytest.approx(30.0)
    assert document["bodies"] == {"one": 3, "other": 1}


def test_means_are_of_each_part() -> None:
    assert means_of([np.array([0, 2]), np.array([1])], np.array([1.0, 5.0, 3.0])) == pytest.approx([2.0, 5.0])
