"""The weights of the signs come out of cases: those that tell count, those that do not tell hardly do."""

import numpy as np

from breastrig.fitting.starts.stance_signs import LikelyStance, stance_signs
from breastrig_studies.stance_signs import MOST, ScanSigns, estimated, table

STANCES = ("standing", "supine")


def cases(count: int) -> list[ScanSigns]:
    """Of which only how far the nipples are in front and over the folds tells; arms are not always seen."""
    random, found = np.random.default_rng(5), []
    for number in range(count):
        lies = bool(number % 2)
        signs = {
            name: random.normal(0.15, 0.05) for name, sign in stance_signs().supine.signs.items() if not sign.by_hand
        }
        signs |= {"nipples_in_front": random.normal(0.2 - 0.1 * lies, 0.04)}
        signs |= {"nipples_over_folds": random.normal(0.2 + 0.1 * lies, 0.04)}
        if number % 3 == 0:
            del signs["arms"]
        found.append(ScanSigns("", "development", f"source {number % 5}", STANCES[lies], signs))
    return found


def test_only_signs_that_distinguish_are_estimated_and_those_set_by_hand_stay() -> None:
    given = cases(400)
    found = estimated(given, stance_signs().supine, "supine")
    odds = np.array([found.log_odds(each.signs) for each in given])
    lies = np.array([each.stance == "supine" for each in given])
    assert ((odds > 0.0) == lies).mean() > 0.95
    assert found.signs["upright"] == stance_signs().supine.signs["upright"]
    counts = {name: abs(sign.weight) * sign.most / MOST for name, sign in found.signs.items() if not sign.by_hand}
    telling = {"nipples_in_front", "nipples_over_folds"}
    assert min(counts[name] for name in telling) > 3.0 * max(counts[name] for name in counts.keys() - telling)
    assert abs(odds[lies].mean() + odds[~lies].mean()) < 0.2 * odds[lies].mean()  # half way between them


def test_the_table_counts_what_is_wrong_and_what_is_doubted() -> None:
    scans = [ScanSigns(stance, "development", "a", stance, {}) for stance in STANCES for _ in range(2)]
    found = [
        LikelyStance(*each) for each in (("supine", False), ("supine", True), ("supine", True), ("standing", False))
    ]
    lines = list(table(scans, found))
    assert [line.split() for line in lines] == [
        ["standing", "of", "2", "wrong", "1,", "wrong", "and", "unsure", "1,", "right", "and", "unsure", "0"],
        ["supine", "of", "2", "wrong", "0,", "wrong", "and", "unsure", "1,", "right", "and", "unsure", "0"],
    ]
