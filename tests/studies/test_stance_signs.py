"""The weights of the signs come out of cases: those that tell count, those that do not tell hardly do."""

import numpy as np

from breastrig.fitting.starts.supine_or_standing import stance_signs
from breastrig_studies.stance_signs import MOST, ScanSigns, estimated, table


def cases(count: int) -> list[ScanSigns]:
    """Of which only how far the nipples are in front and over the folds tells; arms are not always seen."""
    random, found = np.random.default_rng(5), []
    for number in range(count):
        lies = bool(number % 2)
        signs = {name: random.normal(0.15, 0.05) for name, sign in stance_signs().signs.items() if not sign.by_hand}
        signs |= {"nipples_in_front": random.normal(0.2 - 0.1 * lies, 0.04)}
        signs |= {"nipples_over_folds": random.normal(0.2 + 0.1 * lies, 0.04)}
        if number % 3 == 0:
            del signs["arms"]
        found.append(ScanSigns("", "choose", f"source {number % 5}", lies, signs))
    return found


def test_only_signs_that_distinguish_are_estimated_and_those_set_by_hand_stay() -> None:
    given = cases(400)
    found = estimated(given, stance_signs())
    odds = np.array([found.log_odds(each.signs) for each in given])
    lies = np.array([each.lies for each in given])
    assert ((odds > 0.0) == lies).mean() > 0.95
    assert found.signs["upright"] == stance_signs().signs["upright"]
    counts = {name: abs(sign.weight) * sign.most / MOST for name, sign in found.signs.items() if not sign.by_hand}
    telling = {"nipples_in_front", "nipples_over_folds"}
    assert min(counts[name] for name in telling) > 3.0 * max(counts[name] for name in counts.keys() - telling)
    assert abs(odds[lies].mean() + odds[~lies].mean()) < 0.2 * odds[lies].mean()  # half way between them


def test_the_table_counts_what_is_wrong_and_what_is_doubted() -> None:
    scans = [ScanSigns(kind, "choose", "a", kind == "lying", {}) for kind in ("lying", "standing") for _ in range(2)]
    lines = list(table(scans, np.array([-0.5, 3.0, 3.0, -0.5]), unsure=1.0))
    assert [line.split() for line in lines] == [
        ["lying", "of", "2", "wrong", "0,", "wrong", "and", "unsure", "1,", "right", "and", "unsure", "0"],
        ["standing", "of", "2", "wrong", "1,", "wrong", "and", "unsure", "0,", "right", "and", "unsure", "1"],
    ]
