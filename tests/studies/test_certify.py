"""The guarantee of the verdict: what is counted, its bound, and the limit that is chosen."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.cohort import write_patient
from scipy.stats import binom

from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.verdicts import verdict
from breastrig.rig.model import Rig
from breastrig_studies.cohort import TEST, VALIDATION
from breastrig_studies.studies.trust import certify
from breastrig_studies.studies.trust.certify import (
    Fit,
    amount_of,
    bound,
    by_woman,
    chosen_limit,
    main,
    read_fits,
    summary,
    wrong_women,
)

RIGHT = Fit("w", "a", "all", else_good=True, said=0.008, true=0.006, held=0.9)
WRONG = replace(RIGHT, true=0.016)


def women(count: int, fit: Fit = RIGHT, first: int = 0) -> list[Fit]:
    return [replace(fit, woman=f"w{k}") for k in range(first, first + count)]


def test_a_share_of_wrong_ones_at_the_bound_is_missed_once_in_twenty() -> None:
    for wrong, of in ((0, 17), (1, 63), (3, 240)):
        assert binom.cdf(wrong, of, bound(wrong, of)) == pytest.approx(0.05)
    assert bound(0, 148) > 0.02 > bound(0, 149)
    assert bound(0, 0) == bound(3, 3) == 1.0


def test_a_woman_is_wrong_where_one_of_her_good_fits_is() -> None:
    others = [replace(WRONG, woman="w1", said=0.010), replace(WRONG, woman="w1", else_good=False)]
    found = by_woman([*women(3), replace(WRONG, woman="w0"), *others, replace(RIGHT, woman="w9", said=0.010)])
    assert wrong_women(found, 0.009) == (1, 3)  # nothing of the fourth is good
    assert wrong_women(found, 0.010) == (2, 4)
    lines = "\n".join(summary(found, 0.009))
    assert "good of right ones with picks: 3 of 4" in lines
    assert "fits 1 of 4, women 1 of 3" in lines


@pytest.mark.parametrize(
    ("wrong", "limit"),
    [
        ([], 0.020),
        (women(1, replace(WRONG, said=0.0125)), 0.012),  # 150 women: not one may be wrong
        ([*women(1, replace(WRONG, said=0.0125)), *women(99, replace(RIGHT, said=0.0145), 300)], 0.012),  # 15 mm held
        (women(1, replace(WRONG, said=0.0075)), None),
    ],
)
def test_the_limit_is_the_largest_below_which_every_one_holds(wrong: list[Fit], limit: float | None) -> None:
    assert chosen_limit(by_woman([*women(150), *wrong])) == limit


def test_half_of_few_landmarks_may_be_three() -> None:
    assert [amount_of(picked, 7) for picked in (0, 3, 4, 7)] == ["none", "three", "half", "all"]
    assert amount_of(3, 3) == "all"


def test_no_limit_is_chosen_of_too_few_women() -> None:
    assert chosen_limit(by_woman(women(148))) is None


def test_of_a_cohort_only_the_women_of_the_group_are_fitted_and_once(
    tmp_path: Path, rig: Rig, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, table = tmp_path / "cohort", tmp_path / "table.csv"
    for name in ("a_validation", "b_test", "c_development"):
        write_patient(folder / name, rig, 1, "makehuman", ("standing",))
    limits = verdict.verdict_limits(rig)
    monkeypatch.setattr(certify, "trials", lambda scene: iter([{}, scene.landmarks]))
    fits = list(read_fits(folder, rig, load_recipe("default"), VALIDATION))
    assert {each.woman for each in fits} == {"a_validation"}
    assert verdict.verdict_limits(rig) is limits  # those of the program again
    assert [each.amount for each in fits] == ["none", "all"]
    assert all(0.0 < each.said < 0.1 and np.isfinite(each.true) for each in fits)
    monkeypatch.setattr(certify, "fits_of", lambda *_: pytest.fail("fitted again"))
    main(table, [folder], VALIDATION)
    assert "no limit holds" in capsys.readouterr().out
    _, row = table.read_text("utf-8").splitlines()
    assert row.startswith(f"cohort makehuman,a_validation,{len(fits)},")
    monkeypatch.setattr(
        certify, "fits_of", lambda case, source, *_: [replace(RIGHT, woman=case.patient, source=source)]
    )
    main(table, [folder], TEST)
    assert "chosen" not in capsys.readouterr().out  # of test women nothing is chosen
    assert "b_test,1,1,1,0,90,8.0,6.0" in table.read_text("utf-8")
