"""Do the checks that a fit asks for narrow lines as promised, and are lines then as true as with six picks?

python -m breastrig_studies.studies.trust.checked TABLE.csv GROUP COHORT [COHORT ...]

The first scan of each patient of the cohorts' group in each stance (development, validation; all where a cohort is not
divided) is fitted without picks. The first two landmarks that its posterior asks for (fitting/checks) and that the scan
truly shows are then picked: truly, and as a person does it, who says yes to a place that is less than CLICK_ERROR off
and else clicks as far from the true one. Six are FIRST_HALF of landmarks.py, picked the same two ways. Lines are all
places of the seen skin of the breasts; how far they are off is across lines whose directions are drawn, against the
reference fit (certainty.py).
"""

import csv
import sys
from collections.abc import Iterable
from itertools import islice
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.checks.basis import CheckBasis, check_basis, on_vertices
from breastrig.fitting.checks.choose import fewer_fingers, next_checks
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.uncertainty.radii import Radii, planned_on, radii
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.radii_factors import fitted
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.landmarks import CLICK_ERROR, FIRST_HALF
from breastrig_studies.studies.reference_fit import reference_fit
from breastrig_studies.studies.trust.certainty import SHOWN, across

LEVEL = 0.9
CHECKS = 2
SEED = 29
ALL = "all"
WHO = ("cohort", "patient", "stance", "checks")
FITS = ("none", "one", "two", "two_clicked", "six", "six_clicked", "all")
COLUMNS = (
    *WHO,
    *("promised_one_mm", "promised_two_mm"),
    *(f"{fit}_{what}" for fit in FITS for what in ("stated_mm", "off_mm", "held")),
)
Row = dict[str, str | float]


def promised(basis: CheckBasis, posterior: Posterior, known: Radii) -> dict[str, float]:
    """Name -> m, the lines' error that is expected after this check and those before, of the first two."""
    vertices, widths = basis.widths([on_vertices(part) for part in planned_on(posterior.task.rig, known.seen)])
    steps = next_checks(basis.gaussian(posterior.state, vertices), basis.observable, widths)
    return {basis.observable.names[step.index]: step.width for step in islice(steps, CHECKS)}


def as_clicked(scene: Scene, places: dict[str, Array], expected: dict[str, Array]) -> dict[str, Array]:
    """Where a person would have these (3,) m `places` who was shown the `expected` ones."""
    rng = np.random.default_rng(SEED)
    near = {n for n, place in places.items() if np.linalg.norm(expected.get(n, np.inf) - place) <= CLICK_ERROR}
    return {
        name: expected[name] if name in near else scene.along_the_skin(place, CLICK_ERROR, rng)
        for name, place in places.items()
    }


def checked(scene: Scene, rig: Rig, recipe: Recipe) -> Row | None:
    """The row of one scan; None where a fit fails, nothing true is known of it, or it shows too few landmarks."""
    true, alone = reference_fit(scene, rig, recipe), scene.place(rig).parameters
    first = fitted(scene, rig, recipe, {}, alone)
    known = None if first is None else radii(first)
    if true is None or first is None or known is None:
        return None
    gaps = {name: float(scene.target.vertex_tree.query(place)[0]) for name, place in scene.landmarks.items()}
    shown = {name: place for name, place in scene.landmarks.items() if gaps[name] < SHOWN}
    basis = check_basis(first, known, {}, {*rig.landmark_names} - shown.keys())  # a person cannot see the others
    widths = promised(basis, first, known)
    if len(widths) < CHECKS:
        return None
    expected = dict(zip(rig.landmark_names, basis.places.points, strict=True))
    two, six = ({name: shown[name] for name in names if name in shown} for names in (widths, FIRST_HALF))
    picks = {"none": {}, "one": dict(list(two.items())[:1]), "two": two, "six": six, "all": shown}
    picks |= {f"{name}_clicked": as_clicked(scene, picks[name], expected) for name in ("two", "six")}
    row: Row = {"checks": " ".join(widths)}
    row |= {f"promised_{n}_mm": 1e3 * width for n, width in zip(("one", "two"), widths.values(), strict=True)}
    lines = np.unique(np.concatenate(planned_on(rig, known.seen)))
    for name in FITS:
        found = first if name == "none" else fitted(scene, rig, recipe, picks[name], scene.start(rig, picks[name]))
        its = None if found is None else radii(found)
        if found is None or its is None:
            return None
        off = across(found.state.vertices[lines] - true.vertices[lines], found.state.normals[lines])
        row |= {f"{name}_stated_mm": 1e3 * its.lines, f"{name}_off_mm": 1e3 * float(np.quantile(off, LEVEL))}
        row[f"{name}_held"] = float(np.mean(off <= its.lines))
    return row


def chosen(folder: Path, group: str) -> list[Case]:
    """The first scan of each patient of the group in each stance, never of the test set."""
    found: dict[tuple[str, str], Case] = {}
    for case in read_cohort(folder):
        if not case.held_out and not case.coloured and group in (case.group, ALL):
            found.setdefault((case.patient, case.stance), case)
    return list(found.values())


def summary(rows: list[Row]) -> Iterable[str]:
    """For each stance a few lines: widths promised, stated and true, medians over scans."""

    def of(name: str, stance: str) -> Array:
        return np.array([row[name] for row in rows if row["stance"] == stance], dtype=np.float64)

    for stance in sorted({str(row["stance"]) for row in rows}):
        yield f"{stance}, {len(of('none_off_mm', stance))} scans; medians: stated, off (mean), held (mean)"
        for fit in FITS:
            stated, off, held = (of(f"{fit}_{what}", stance) for what in ("stated_mm", "off_mm", "held"))
            yield (
                f"  {fit:12s}{np.median(stated):6.1f} mm {np.median(off):6.1f} ({off.mean():.1f}) mm {held.mean():6.0%}"
            )
        for number in ("one", "two"):
            share = of(f"{number}_stated_mm", stance) / of(f"promised_{number}_mm", stance)
            low, middle, high = np.quantile(share, [0.1, 0.5, 0.9])
            yield (
                f"  stated over promised after {number}: mean {share.mean():.2f}, median {middle:.2f}, "
                f"80 % within {low:.2f} to {high:.2f}"
            )
        for fit in ("two", "two_clicked"):
            more = of(f"{fit}_off_mm", stance) - of(f"{fit.replace('two', 'six')}_off_mm", stance)
            yield f"  farther off after {fit} than with six: median {np.median(more):.1f} mm, mean {more.mean():.1f} mm"
        wide = zip(*(1e-3 * of(n, stance) for n in ("none_stated_mm", "promised_two_mm", "two_stated_mm")), strict=True)
        gains = [(fewer_fingers(a, b) > 0, fewer_fingers(a, c) > 0) for a, b, c in wide]
        kept = [real for said, real in gains if said]
        missed = sum(real for said, real in gains if not said)
        yield f"  a finger promised in {len(kept)}, kept in {sum(kept)}; not promised and gained in {missed}"


def main(table: str, group: str, folders: list[str]) -> None:
    """Writes the table, and the summary to the terminal."""
    rig, recipe, rows = read_rig(default_rig_path()), load_recipe("default"), list[Row]()
    with Path(table).open("w", newline="", encoding="utf-8") as file:
        lines = csv.DictWriter(file, COLUMNS)
        lines.writeheader()
        for folder in map(Path, folders):
            for case in chosen(folder, group):
                row = checked(read_scene(case), rig, recipe)
                if row is not None:
                    rows.append(row | {"cohort": folder.name, "patient": case.patient, "stance": case.stance})
                    lines.writerow({k: round(v, 2) if isinstance(v, float) else v for k, v in rows[-1].items()})
                    file.flush()
    sys.stdout.write("\n".join(summary(rows)) + "\n")


if __name__ == "__main__":
    given = arguments(__doc__, "TABLE", "GROUP", "COHORT...")
    main(given.table, given.group, given.cohort)
