"""Whether what two visits show is true: nothing said where nothing changed, real changes seen, bands held.

python -m breastrig_studies.visits.held PAIRS TABLE HALF

PAIRS: the folder of breastrig_studies.visits.pairs.  TABLE: a CSV with a row a pair.  The terminal gets the summary,
and the factors of visits.toml that this half would give: of points such that nine of ten pairs have at most 10 % false
ones, of the others such that nine of ten numbers are held, each patient counting alike.

Truths.  Of a point: how far the true skin under it moved along its normal, without posture; both true skins are laid on
each other as scans are.  Of a volume: the ml that were added; a change of weight has none.  Of each other measure: the
same measure of the earlier fit's mesh laid on the true skin, with the true landmarks, then carried to the other skin
with the points of the skin.
"""

import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BreastRigError
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.measures import measures
from breastrig.report.stance import Stance
from breastrig.report.table import Row, Value, changes
from breastrig.report.visits.alignment import laid, untouched
from breastrig.report.visits.change import Change, change_between, visit_calibration, way_to
from breastrig.report.visits.series import changed_rows
from breastrig.report.visits.symmetry import SHAPE, VOLUME, symmetry_rows
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import fit_folder_of
from breastrig.use.reports.report import stance_of
from breastrig_studies.arguments import arguments

LEVEL = 0.9
WAYS = ("picked", "alone")
STILL = 5e-4  # m, up to which a point has not changed
BINS = (2.0, 3.0, 4.0, 6.0, 10.0, 100.0)  # mm of true change
CELLS = ("left", "right", "value", "difference")
ONE_VISIT = "one visit"  # kind of the symmetries themselves, which have no other study


@dataclass(frozen=True)
class Off:
    """One number of a pair against its truth."""

    measure: str
    kind: str  # of its row; with ", left - right"
    unit: str
    error: float
    half: float | None  # of its band


@dataclass(frozen=True)
class Pair:
    """What one pair of visits showed."""

    patient: str
    stance: str
    way: str
    kind: str
    numbers: dict[str, Any]  # of the skin's points
    offs: list[Off] = field(default_factory=list)


class Before:
    """The earlier visit of several pairs: its fit, and its mesh on the true skin."""

    def __init__(self, rig: Rig, folder: Path, way: str) -> None:
        self.rig, self.truth = rig, np.load(folder / "truth.npz")
        self.stance = stance_of(fit_folder_of(folder / way, rig))
        self.faces: Integers = self.truth["faces"].astype(np.int64)
        seen, placed = ClosestPointSearch(self.truth["seen"].astype(float), self.faces), self.truth["placed"]
        there = (self.stance.vertices - placed[:3, 3]) @ np.linalg.inv(placed[:3, :3]).T
        self.under: SurfacePoints = seen.query(there).on_mesh
        self.rows, self.true_rows = _rows(self.stance), _rows(self.true_stance(self.truth["before"], self.truth))

    def true_stance(self, skin: Array, truth: Any) -> Stance:
        """The earlier fit's mesh on this true skin (V, 3) m, with the true landmarks of `truth`."""
        vertices = self.under.positions(skin.astype(float), self.faces)
        picked = {name: truth[f"at_{name}"] for name in self.rig.landmark_names if f"at_{name}" in truth}
        return Stance(self.rig, vertices, skin.astype(float), self.faces, self.stance.name, picked)

    def true_change(self, at: Integers, after: Array) -> Array:
        """(M,) m outwards that the true skin under the earlier fit's vertices `at` moved along its normal."""
        first, second, faces = self.truth["before"].astype(float), after.astype(float), self.faces
        normals, then = vertex_normals(first, faces), ClosestPointSearch(second, faces)
        beside = untouched(self.rig)
        still = self.under[beside[np.isfinite(self.stance.distances[beside])]]
        places = still.positions(first, faces), still.directions(normals, faces), still.positions(second, faces)
        on = self.under[at]
        return way_to(on.positions(first, faces), on.directions(normals, faces), then, laid(*places, then))[0]


def _rows(stance: Stance) -> tuple[Row, ...]:
    found = measures(stance)
    return (*found, *symmetry_rows(stance, found))


def scored(before: Before, folder: Path, way: str) -> Pair:
    """The pair of `before` and the visit in `folder`.  Raises BreastRigError where they cannot be compared."""
    after = np.load(folder / "truth.npz")
    later = stance_of(fit_folder_of(folder / way, before.rig))
    found = change_between(before.stance, later)
    at = np.flatnonzero(np.isfinite(found.along))
    true = before.true_change(at, after["after"])
    at, true = at[np.isfinite(true)], true[np.isfinite(true)]
    along, said, half, spread = found.along[at], found.said[at], found.half, found.alignment.spread
    still, off = np.abs(true) < STILL, np.abs(along - true)
    kind, side, ml, mm, capture = after["change"]
    numbers = {
        "ml": float(ml), "mm": float(mm), "capture": f"{before.truth['change'][4]} {capture}",
        "half_mm": 1e3 * half,
        "error_mm": 1e3 * float(np.quantile(off, LEVEL)),
        "held": float(np.mean(off <= half)),
        "false": float(said[still].mean()) if still.sum() > 50 else None,
        "score": float(np.quantile(off[still] / spread, LEVEL)) if still.sum() > 50 else None,
    }  # fmt: skip
    for low, high in pairwise(BINS):
        of = (np.abs(true) >= 1e-3 * low) & (np.abs(true) < 1e-3 * high)
        right = said & (np.sign(along) == np.sign(true))
        numbers[f"seen_{low:g}_mm"] = float(right[of].mean()) if of.sum() > 10 else None
    rows, true_rows = _rows(later), _rows(before.true_stance(after["after"], after))
    offs = [*_of_changes(before, found, rows, true_rows), *_of_symmetry(rows, true_rows)]
    if kind != "weight":
        offs += _of_volumes(found, str(side), float(ml))
    return Pair(folder.parent.name.rsplit("_", 1)[0], later.name, way, str(kind), numbers, offs)


def _of_volumes(found: Change, changed: str, ml: float) -> Iterator[Off]:
    for side in "LR":
        value = found.volume(side)
        if value is not None:
            yield Off("volume", "volume", "ml", value.value - (ml if side == changed else 0.0), value.margin)


def _of_changes(before: Before, found: Change, rows: tuple[Row, ...], true: tuple[Row, ...]) -> Iterator[Off]:
    truths = {row.key: row for row in changes(before.true_rows, true)}
    for row in changed_rows(before.rows, rows, found):
        if row.measure != "volume" and row.key in truths:
            yield from _offs(row, truths[row.key], row.kind)


def _of_symmetry(rows: Sequence[Row], true: Sequence[Row]) -> Iterator[Off]:
    truths = {row.measure: row for row in true}
    for row in rows:
        if row.measure in (VOLUME, SHAPE) and row.measure in truths:
            yield from _offs(row, truths[row.measure], ONE_VISIT)


def _offs(row: Row, truth: Row, kind: str) -> Iterator[Off]:
    for cell in CELLS:
        value, true = (getattr(each, cell) for each in (row, truth))
        if isinstance(value, Value) and true is not None:
            more = ", left - right" if cell == "difference" else ""
            yield Off(row.measure, kind + more, row.unit, value.value - true.value, value.margin)


def by_patient(values: Sequence[tuple[str, float]], level: float = LEVEL) -> float:
    """The quantile of (patient, value), each patient counting alike."""
    patients, numbers = [patient for patient, _ in values], np.array([value for _, value in values])
    order = np.argsort(numbers)
    weights = np.array([1.0 / patients.count(patient) for patient in patients])[order]
    share = np.cumsum(weights) / weights.sum()
    return float(numbers[order][min(int(np.searchsorted(share, level)), len(numbers) - 1)])


def summary(rig: Rig, pairs: Sequence[Pair]) -> Iterator[str]:
    """What the pairs say, by stance and whether landmarks were picked."""
    for stance, way in sorted({(pair.stance, pair.way) for pair in pairs}):
        own = [pair for pair in pairs if (pair.stance, pair.way) == (stance, way)]
        known = {key: [n for pair in own if (n := pair.numbers[key]) is not None] for key in own[0].numbers}
        mean = {key: float(np.mean(known[key] or [np.nan])) for key in known if key != "capture"}
        yield (
            f"{stance}, {way}, {len(own)} pairs of {len({pair.patient for pair in own})}: half band "
            f"{mean['half_mm']:.1f} mm, 90 % of points within {mean['error_mm']:.1f}, held {mean['held']:.0%}; "
            f"unchanged points said {mean['false']:.1%}, pairs with at most 10 %: "
            f"{np.mean(np.array(known['false']) <= 0.1):.0%} of {len(known['false'])}"
        )
        yield "  seen: " + ", ".join(f"from {low:g} mm {mean[f'seen_{low:g}_mm']:.0%}" for low in BINS[:-1])
        offs = [off for pair in own for off in pair.offs]
        for key in dict.fromkeys((off.measure, off.kind, off.unit) for off in offs):
            yield f"  {', '.join(key)}: {_held([o for o in offs if (o.measure, o.kind, o.unit) == key])}"
    calibration = visit_calibration(rig)
    assert calibration is not None
    scores = [(pair.patient, pair.numbers["score"]) for pair in pairs if pair.numbers["score"] is not None]
    yield f"factor of this half for points: {by_patient(scores):.2f}"
    yield f"for volumes: {calibration.volume * by_patient(_scores(pairs, 'ml')):.2f}"
    for way in WAYS:
        of_way = [pair for pair in pairs if pair.way == way]
        yield f"for lengths, {way}: {calibration.lengths * by_patient(_scores(of_way, 'mm')):.2f}"
    shapes = [(p.patient, abs(o.error)) for p in pairs for o in p.offs if (o.measure, o.kind) == (SHAPE, ONE_VISIT)]
    yield f"half a band of shape symmetry: {by_patient(shapes):.2f} mm"


def _scores(pairs: Sequence[Pair], unit: str) -> list[tuple[str, float]]:
    """Errors of changes in half bands."""
    return [
        (pair.patient, abs(off.error) / off.half)
        for pair in pairs
        for off in pair.offs
        if off.unit == unit and off.half and off.kind != ONE_VISIT
    ]


def _held(offs: Sequence[Off]) -> str:
    errors, digits = np.array([off.error for off in offs]), 3 if offs[0].unit == "1" else 1
    median, most = np.quantile(np.abs(errors), (0.5, LEVEL))
    said = f"off {median:.{digits}f} (median), {most:.{digits}f} (90 %), mean {errors.mean():+.{digits}f}"
    known = [off for off in offs if off.half is not None]
    if not known:
        return f"{said}, no band, {len(offs)}"
    half, held = np.median([off.half for off in known]), np.mean([abs(o.error) <= (o.half or 0.0) for o in known])
    return f"{said}, half band {half:.{digits}f}, held {held:.0%} of {len(known)}"


def _written(pair: Pair) -> dict[str, Any]:
    row = {"patient": pair.patient, "stance": pair.stance, "way": pair.way, "kind": pair.kind, **pair.numbers}
    for off in pair.offs:
        name = next(n for k in range(9) if (n := f"{off.measure}, {off.kind} {k}") + " error" not in row)
        row |= {f"{name} error": off.error, f"{name} half": off.half}
    return {key: round(value, 4) if isinstance(value, float) else value for key, value in row.items()}


def main(folder: Path, table: Path, half: str) -> None:
    """Writes the table, and the summary to the terminal."""
    rig, pairs = read_rig(default_rig_path()), list[Pair]()
    for base in sorted(folder.glob(f"*_{half}_*")):
        for way in WAYS:
            done = {f.parent.parent.name for f in base.glob(f"*/{way}/result.json")}
            if "before" not in done:
                continue
            before = Before(rig, base / "before", way)
            for kind in (k for k in ("same", "volume", "dent", "weight") if k in done):
                try:
                    pairs.append(scored(before, base / kind, way))
                except BreastRigError as error:
                    sys.stderr.write(f"{base.name} {kind} {way}: {error}\n")
    rows = [_written(pair) for pair in pairs]
    with table.open("w", newline="", encoding="utf-8") as file:
        lines = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)))
        lines.writeheader()
        lines.writerows(rows)
    sys.stdout.write("\n".join(summary(rig, pairs)) + "\n")


if __name__ == "__main__":
    given = arguments(__doc__, "PAIRS", "TABLE", "HALF")
    main(Path(given.pairs), Path(given.table), given.half)
