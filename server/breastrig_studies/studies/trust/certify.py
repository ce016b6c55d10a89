"""How often is a fit that is called good wrong?  Prints the share with its bound, and writes a table of all women.

python -m breastrig_studies.studies.trust.certify TABLE.csv COHORT... [--test]

Wrong: more than a tenth of the points of lines on the breasts are more than WRONG off, across (docs/decisions/0035).
Every scan is fitted with the picks of radii_factors.py.  A woman is wrong where one of her good fits is; bounds are of
exact binomial tests over women, whose fits are no independent draws.  The limit of the line error is chosen on
validation women (fixed sequence testing: Angelopoulos et al., Learn then test, 2021) and tested on the test women, whom
--test reads instead.  Fits are kept beside each cohort, so that a run that was broken off goes on.
"""

import csv
import json
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import takewhile
from operator import itemgetter
from pathlib import Path
from unittest.mock import patch

import numpy as np
from scipy.stats import binomtest, spearmanr

from breastrig.core.errors import BadInput
from breastrig.fitting.picks.issues import unusual
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.orientation import MIN_LANDMARKS
from breastrig.fitting.task import FitTask, ended
from breastrig.fitting.uncertainty.radii import planned_on
from breastrig.fitting.verdicts import verdict
from breastrig.fitting.verdicts.reasons import GivenLandmarks
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import TEST, VALIDATION, Case, read_cohort
from breastrig_studies.radii_factors import trials
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.reference_fit import reference_fit
from breastrig_studies.studies.trust.certainty import across

WRONG = 0.015  # m
RISK, SURE = 0.02, 0.95  # of good fits at most this share is wrong, with this confidence
LIMITS = np.arange(5, 21) / 1e3  # m, of the line error, from strict to loose
AMOUNTS = ("all", "half", "three", "none")
SEED = 41
ANY = 1e3  # m, a limit that every line error keeps


@dataclass(frozen=True)
class Fit:
    """One fit."""

    woman: str
    source: str  # of her shape: cohort, and kind of body or source of the warp
    amount: str  # of landmarks picked, of those that the scan shows
    else_good: bool  # nothing but its line error speaks against it
    said: float  # m, its line error
    true: float  # m, how far nine of ten points of lines on the breasts are off at most, across the line
    held: float  # share of them within `said`

    @property
    def wrong(self) -> bool:
        return self.true > WRONG

    def good(self, limit: float) -> bool:
        """Whether it is called good up to this line error (m)."""
        return self.else_good and self.said <= limit


def amount_of(picked: int, shown: int) -> str:
    """A word of AMOUNTS for so many of the landmarks that the scan shows."""
    return "none" if not picked else "all" if picked == shown else "three" if picked == MIN_LANDMARKS else "half"


def fits_of(case: Case, source: str, rig: Rig, recipe: Recipe) -> Iterator[Fit]:
    """The fits of one scan; BadInput where its true skin is not known."""
    scene, limits = read_scene(case), verdict.verdict_limits(rig)
    true = reference_fit(scene, rig, recipe)
    if true is None or limits is None:
        raise BadInput(f"{case.folder} needs truth.ply, and the rig limits of verdicts, for fits to be certified.")
    lines = limits.lines.model_copy(update=dict.fromkeys(("check", "placed", "unknown"), ANY))
    alone, tried = scene.place(rig), [*trials(scene)]
    for picks in tried:
        start = scene.start(rig, picks) if picks else alone.parameters
        task = FitTask(rig, scene.target, start, recipe, {}, case.stance).with_picks(picks)
        *_, last = checked_iterates(task)
        if not last.is_finite:
            continue
        posterior, given = Posterior(ended(task, last), last.parameters), GivenLandmarks(len(picks), 0, len(picks))
        doubts = (*last.not_followed, *unusual(posterior))
        with patch.object(verdict, "verdict_limits", return_value=limits.model_copy(update={"lines": lines})):
            said = verdict.judge(posterior, last.status, given, doubts, None if picks else alone.margin)
        assert said.radii is not None
        points, state, error = np.concatenate(planned_on(rig, said.radii.seen)), posterior.state, said.radii.lines
        off = across((state.vertices - true.vertices)[points], state.normals[points])
        amount, good = amount_of(len(picks), max(map(len, tried))), said.verdict.level == "good"
        far, held = float(np.quantile(off, 0.9)), float((off <= error).mean())
        yield Fit(case.patient, source, amount, good, error, far, held)


def read_fits(folder: Path, rig: Rig, recipe: Recipe, group: str) -> Iterator[Fit]:
    """The fits of all women of the cohort's group, computed where they are not kept."""
    kept = folder.parent / f"certified_{folder.name}"
    kept.mkdir(exist_ok=True)
    for case in read_cohort(folder):
        if case.group != group:
            continue
        file = kept / f"{case.patient}_{case.name}.json"
        if not file.is_file():
            known = json.loads((case.folder.parent / "patient.json").read_text("utf-8"))
            source = f"{folder.name} {known.get('kind', known.get('source', case.family))}"
            file.write_text(json.dumps([asdict(each) for each in fits_of(case, source, rig, recipe)]), "utf-8")
        yield from (Fit(**each) for each in json.loads(file.read_text("utf-8")))


def bound(wrong: int, of: int) -> float:
    """The share of wrong ones that is not exceeded with SURE (Clopper and Pearson)."""
    return float(binomtest(wrong, of, alternative="less").proportion_ci(SURE).high) if of else 1.0


Women = dict[tuple[str, str], list[Fit]]  # by source and name


def by_woman(fits: Iterable[Fit]) -> Women:
    """The fits of each."""
    found: Women = defaultdict(list)
    for each in fits:
        found[each.source, each.woman].append(each)
    return found


def wrong_women(women: Women, limit: float) -> tuple[int, int]:
    """(those with a good fit that is wrong, those with a good fit)."""
    good = [its for fits in women.values() if (its := [each.wrong for each in fits if each.good(limit)])]
    return sum(map(any, good)), len(good)


def chosen_limit(women: Women) -> float | None:
    """The largest limit (m) up to which RISK holds, from the first one that has women enough to show it; else None."""
    counts = [(limit, *wrong_women(women, limit)) for limit in LIMITS.tolist()]
    enough = [(limit, bound(wrong, of) <= RISK) for limit, wrong, of in counts if bound(0, of) <= RISK]
    return max((limit for limit, _ in takewhile(itemgetter(1), enough)), default=None)


def summary(women: Women, limit: float) -> Iterator[str]:
    """Lines of what is printed of these women."""
    fits = [each for its in women.values() for each in its]
    right = [each.good(limit) for each in fits if each.amount != "none" and not each.wrong]
    good = [its for each in women.values() if (its := [fit.wrong for fit in each if fit.good(limit)])]
    rng, (wrong, of) = np.random.default_rng(SEED), wrong_women(women, limit)
    drawn, of_fits = sum(its[int(rng.integers(len(its)))] for its in good), [each for its in good for each in its]
    shares = np.array([np.mean([each.held for each in its]) for its in women.values()])
    usual = np.mean((shares >= 0.85) & (shares <= 0.95))
    yield f"{len(women)} women, {len(fits)} fits; good of right ones with picks: {sum(right)} of {len(right)}"
    yield f"wrong of good: fits {sum(of_fits)} of {len(of_fits)}, women {wrong} of {of}: at most {bound(wrong, of):.1%}"
    yield f"the same of one good fit drawn of each woman: {drawn}, at most {bound(drawn, of):.1%}"
    yield f"points held: {shares.mean():.1%}, least woman {shares.min():.1%}; 85 to 95 % of {usual:.0%} of the women"
    for amount in AMOUNTS:
        errors = np.array([(each.said, each.true) for each in fits if each.amount == amount])
        if len(errors) > 2:
            rank = spearmanr(*errors.T).statistic
            yield f"{amount}: {len(errors)} fits, {1e3 * np.median(errors[:, 0]):.1f} mm, rank correlation {rank:.2f}"


def write_table(file: Path, women: Women, limit: float) -> None:
    """A row for each woman: counts of her fits, medians over them."""
    with file.open("w", newline="", encoding="utf-8") as opened:
        rows = csv.writer(opened, lineterminator="\n")
        rows.writerow(("source", "woman", "fits", "right", "good", "wrong", "held_percent", "said_mm", "true_mm"))
        for key, fits in sorted(women.items()):
            good, right = [each.wrong for each in fits if each.good(limit)], sum(not each.wrong for each in fits)
            said, true, held = np.median([(1e3 * fit.said, 1e3 * fit.true, 100.0 * fit.held) for fit in fits], axis=0)
            rows.writerow((*key, len(fits), right, len(good), sum(good), f"{held:.0f}", f"{said:.1f}", f"{true:.1f}"))


def main(table: Path, folders: Sequence[Path], group: str) -> None:
    """Fits what is not kept, prints and writes."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    limits = verdict.verdict_limits(rig)
    assert limits is not None
    women = by_woman(fit for folder in folders for fit in read_fits(folder, rig, recipe, group))
    write_table(table, women, limit := limits.lines.placed)
    for source in ("", *sorted({part for whole, _ in women for part in (whole, whole.split()[0])})):
        some = {key: its for key, its in women.items() if key[0].startswith(source)}
        sys.stdout.write("\n  ".join([source or group, *summary(some, limit)]) + "\n")
    if group == VALIDATION:
        for each in LIMITS.tolist():
            wrong, of = wrong_women(women, each)
            sys.stdout.write(f"{1e3 * each:g} mm: {wrong} of {of} women, at most {bound(wrong, of):.1%}\n")
        found = chosen_limit(women)
        sys.stdout.write("no limit holds\n" if found is None else f"chosen: {1e3 * found:g} mm\n")


if __name__ == "__main__":
    options = arguments(__doc__, "TABLE", "COHORT...", "--test")
    main(Path(options.table), [Path(each) for each in options.cohort], TEST if options.test else VALIDATION)
