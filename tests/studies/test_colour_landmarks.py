"""Table A: landmarks proposed with colours and without."""

import numpy as np

from breastrig.fitting.propose import Proposal
from breastrig_studies.studies.colour_landmarks import exchanged


def test_exchanged_sides_are_noticed() -> None:
    left, right = np.array([0.1, 0.0, 0.0]), np.array([-0.1, 0.0, 0.0])
    true = {"nipple_L": left, "nipple_R": right}
    right_way = {name: Proposal(at + 0.01, 0.5, True) for name, at in true.items()}
    wrong_way = {"nipple_L": Proposal(right, 0.5, True), "nipple_R": Proposal(left, 0.5, True)}
    assert not exchanged(right_way, true)
    assert exchanged(wrong_way, true)
    assert not exchanged(wrong_way, {"nipple_L": left})
