"""The weights of the signs come out of cases: those that tell count, those that do not tell hardly do."""

import numpy as np

from breastrig.fitting.starts.supine_or_standing import stance_signs
from breastrig_studies.stance_signs import ScanSigns, answered, estimated, table


def cases(count: int) -> list[ScanSigns]:
    """Of which only the arms and the nipples' distance from each other tell."""
    random, found = np.random.default_rng(5), []
    for number in range(count):
        lies = bool(number % 2)
        signs = {
            "nipples_in_front": random.normal(0.15, 0.05),
            "nipples_apart": random.normal(1.2 + 0.2 * lies, 0.08),
            "arms": random.normal(0.6 + 0.4 * lies, 0.15),
            "energy_less": random.normal(3.0, 30.0),
        }
        found.append(ScanSigns("", "choose", f"source {number % 5}", lies, signs))
    return found


def test_only_signs_that_distinguish_are_estimated() -> None:
    given = cases(400)
    found = estimated(given, stance_signs())
    odds = np.array([found.log_odds(each.signs) for each in given])
    lies = np.array([each.lies for each in given])
    assert ((odds > 0.0) == lies).mean() > 0.95
    spread = {name: np.std([each.signs[name] for each in given]) for name in found.signs}
    spread["energy_less"] = 8.0
    counts = {name: abs(sign.weight) * spread[name] for name, sign in found.signs.items()}
    assert min(counts["arms"], counts["nipples_apart"]) > 3.0 * max(counts["nipples_in_front"], counts["energy_less"])
    assert abs(odds[lies].mean() + odds[~lies].mean()) < 0.2 * odds[lies].mean()  # half way between them


def test_the_table_counts_what_is_wrong_and_what_is_doubted() -> None:
    odds = np.array([-3.0, 0.5, -0.5, 3.0])
    lines = list(table([ScanSigns("", "choose", "a", bool(k % 2), {}) for k in (0, 0, 1, 1)], odds, unsure=1.0))
    assert "standing of   2 wrong  0, wrong and unsure  1, right and unsure  0" in lines[0]
    assert "lying    of   2 wrong  0, wrong and unsure  1, right and unsure  0" in lines[1]


def test_who_lets_her_arms_hang_stands_surely_or_not() -> None:
    signs = {"nipples_in_front": 0.3, "nipples_apart": 1.0, "arms": 0.4, "energy_less": 8.0}
    flat = signs | {"nipples_in_front": -0.2, "nipples_apart": 1.6}
    surely, hardly = (answered(ScanSigns("", "choose", "a", False, each), stance_signs()) for each in (signs, flat))
    assert surely < -stance_signs().unsure < hardly < 0.0
