"""A body of another size than women have is asked about, and nothing else is said of size."""

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.verdicts.verdict import times_larger, unusual_size, verdict_limits
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.clean import compact

RIG = read_rig(default_rig_path())
TURN = exp_so3(np.array([0.3, -1.1, 0.7]))


def size_of(vertices: Array) -> tuple[float, float]:
    limits = verdict_limits(RIG)
    assert limits.size is not None
    found = times_larger(RIG, vertices, ScanTarget(vertices, RIG.faces), "standing", limits.size)
    assert found is not None
    return found


def test_a_scan_that_is_so_much_larger_says_so_however_it_lies() -> None:
    size, deviations = size_of(RIG.template)
    for times in (0.8, 1.1, 1.4):
        larger = size_of(times * RIG.template @ TURN.T + [0.2, -3.0, 1.0])
        assert larger[0] == pytest.approx(times * size)
        assert (larger[1] - deviations) / np.log(times) == pytest.approx(deviations / np.log(size))


def test_the_model_is_as_large_as_women_are_and_at_twice_its_size_she_is_to_be_measured() -> None:
    limits = verdict_limits(RIG)
    assert unusual_size(limits, RIG, RIG.template, ScanTarget(RIG.template, RIG.faces), "standing") == ()
    for times, words in ((0.7, "smaller"), (1.4, "larger")):
        vertices = times * RIG.template
        (reason,) = unusual_size(limits, RIG, vertices, ScanTarget(vertices, RIG.faces), "standing")
        assert words in reason.fact
        ends = RIG.landmark_points(("suprasternal_notch", "umbilicus")).positions(vertices, RIG.faces)
        assert f"{100 * np.linalg.norm(ends[1] - ends[0]):.0f} cm in this scan" in reason.advice[0]


def test_what_is_not_seen_says_nothing_of_size() -> None:
    limits = verdict_limits(RIG)
    above = np.flatnonzero(RIG.template[:, 1] > np.median(RIG.template[:, 1]))
    one = RIG.faces[np.isin(RIG.faces, above[RIG.template[above, 0] > 0.05]).all(axis=1)]
    assert (
        unusual_size(limits, RIG, 2.0 * RIG.template, ScanTarget(*compact(2.0 * RIG.template, one)), "standing") == ()
    )


def test_shoulders_that_arms_bring_nearer_make_no_lying_woman_small() -> None:
    limits = verdict_limits(RIG)
    narrow = RIG.template * [0.75, 1.0, 1.0]
    seen = ScanTarget(narrow, RIG.faces)
    assert "smaller" in unusual_size(limits, RIG, narrow, seen, "standing")[0].fact
    assert unusual_size(limits, RIG, narrow, seen, "supine") == ()
