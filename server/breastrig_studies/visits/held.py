"""Whether what two visits show is true: nothing said where nothing changed, real changes seen, bands held.

python -m breastrig_studies.visits.held PAIRS TABLE HALF

PAIRS: the folder of breastrig_studies.visits.pairs.  TABLE: a CSV with a row a pair.  The terminal gets the summary,
and the factors of visits.toml that this half would give: of points such that nine of ten pairs have at most 10 % false
ones, of volumes such that nine of ten changes are held, each patient counting alike.  The truth of a point is how far
the true skin under it moved along its normal, without posture; both true skins are laid on each other as scans are.
"""

import csv
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BreastRigError
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_areas, vertex_normals
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.measures import measures
from breastrig.report.stance import Stance
from breastrig.report.table import changes
from breastrig.report.visits.alignment import laid, untouched
from breastrig.report.visits.change import Change, change_between, way_to
from breastrig.report.volume import vertices_within
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import fit_folder_of
from breastrig.use.reports.report import stance_of
from breastrig_studies.arguments import arguments

LEVEL = 0.9
WAYS = ("picked", "alone")
STILL = 5e-4  # m, up to which a point has not changed
BINS = (2.0, 3.0, 4.0, 6.0, 10.0, 100.0)  # mm of true change
SIDES = {"L": "left", "R": "right"}
LENGTHS = {  # whose truth is between two places of the skin
    "notch_nipple": ("suprasternal_notch", "nipple"),
    "midclavicle_nipple": ("midclavicular", "nipple"),
    "nipple_fold": ("nipple", "inframammary_fold"),
    "nipple_nipple": ("nipple_L", "nipple_R"),
}


def true_change(rig: Rig, earlier: Stance, at: Integers, before: Any, after: Any) -> Array:
    """(M,) m outwards that the true skin under the earlier fit's vertices `at` moved along its normal."""
    faces = before["faces"].astype(np.int64)
    first, second = before["before"].astype(float), after["after"].astype(float)
    seen, normals = ClosestPointSearch(before["seen"].astype(float), faces), vertex_normals(first, faces)
    place = before["placed"]

    def under(members: Integers) -> Any:
        return seen.query((earlier.vertices[members] - place[:3, 3]) @ np.linalg.inv(place[:3, :3]).T).on_mesh

    still = under(np.flatnonzero(untouched(rig) & np.isfinite(earlier.distances)))
    then = ClosestPointSearch(second, faces)
    motion = laid(still.positions(first, faces), still.directions(normals, faces), still.positions(second, faces), then)
    on = under(at)
    return way_to(on.positions(first, faces), on.directions(normals, faces), then, motion)[0]


def scored(rig: Rig, base: Path, kind: str, way: str) -> Iterator[dict[str, Any]]:
    """One row for the pair of visits `before` and `kind`; none where a fit is missing or they cannot be compared."""
    if not all((base / each / way / "result.json").is_file() for each in ("before", kind)):
        return
    before, after = (np.load(base / each / "truth.npz") for each in ("before", kind))
    earlier, later = (stance_of(fit_folder_of(base / each / way, rig)) for each in ("before", kind))
    try:
        found = change_between(earlier, later)
    except BreastRigError as error:
        sys.stderr.write(f"{base.name} {kind} {way}: {error}" + "\n")
        return
    at = np.flatnonzero(np.isfinite(found.along))
    true = true_change(rig, earlier, at, before, after)
    at, true = at[np.isfinite(true)], true[np.isfinite(true)]
    along, half, said = found.along[at], found.half[at], found.said[at]
    sigma = found.deviation[at]
    still = np.abs(true) < STILL
    _, side, ml, mm, capture = after["change"]
    row = {
        "patient": base.name.rsplit("_", 1)[0], "stance": earlier.name, "way": way, "kind": kind,
        "ml": float(ml), "mm": float(mm), "capture": f"{before['change'][4]} {capture}",
        "half_mm": 1e3 * float(np.median(half)),
        "error_mm": 1e3 * float(np.quantile(np.abs(along - true), LEVEL)),
        "held": float(np.mean(np.abs(along - true) <= half)),
        "false": float(said[still].mean()) if still.sum() > 50 else None,
        "score": float(np.quantile(np.abs(along - true)[still] / sigma[still], LEVEL)) if still.sum() > 50 else None,
    }  # fmt: skip
    for low, high in pairwise(BINS):
        of = (np.abs(true) >= 1e-3 * low) & (np.abs(true) < 1e-3 * high)
        right = said & (np.sign(along) == np.sign(true))
        row[f"seen_{low:g}_mm"] = float(right[of].mean()) if of.sum() > 10 else None
    yield row | _volumes(found, side, float(ml)) | _lengths(rig, earlier, later, before, after)


def _volumes(found: Change, changed: str, ml: float) -> dict[str, Any]:
    row: dict[str, Any] = {}
    for side, name in SIDES.items():
        value, inside = found.volume(side), vertices_within(found.earlier.rig, side)
        if value is None or inside is None:
            continue
        faces = found.earlier.rig.faces
        area = float(face_areas(found.earlier.vertices, faces[inside[faces].all(axis=1)]).sum())
        row |= {f"{name}_ml": value.value, f"{name}_true_ml": ml if side == changed else 0.0}
        row |= {f"{name}_half_ml": value.margin, f"{name}_cm2": 1e4 * area}
        row[f"{name}_sigma_mm"] = 1e3 * float(found.deviation[inside].mean())
    return row


def _lengths(rig: Rig, earlier: Stance, later: Stance, before: Any, after: Any) -> dict[str, Any]:
    """Error and half band, mm, of each change of a straight length, by measure and side."""
    row: dict[str, Any] = {}
    for each in changes(measures(earlier), measures(later)):
        if each.measure not in LENGTHS or each.kind != "straight":
            continue
        for side, name in (*SIDES.items(), ("", "value")):
            value = getattr(each, name)
            ends = [
                f"at_{end}_{side}" if f"at_{end}_{side}" in before else f"at_{end}" for end in LENGTHS[each.measure]
            ]
            if value is None or not all(end in truth for end in ends for truth in (before, after)):
                continue
            true = [1e3 * float(np.linalg.norm(truth[ends[0]] - truth[ends[1]])) for truth in (before, after)]
            row[f"{each.measure}_{name}_error"] = value.value - (true[1] - true[0])
            row[f"{each.measure}_{name}_half"] = value.margin
    return row


def by_patient(rows: list[dict[str, Any]], of: str, level: float) -> float:
    """The quantile of a column, each patient counting alike."""
    known = [row for row in rows if row.get(of) is not None]
    count = {patient: sum(row["patient"] == patient for row in known) for patient in {r["patient"] for r in known}}
    values = np.array([row[of] for row in known])
    weights = np.array([1.0 / count[row["patient"]] for row in known])
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / weights.sum()
    return float(values[order][min(int(np.searchsorted(share, level)), len(values) - 1)])


def summary(rows: list[dict[str, Any]]) -> Iterator[str]:
    """What the table says, by stance and whether landmarks were picked."""
    for stance, way in sorted({(row["stance"], row["way"]) for row in rows}):
        own = [row for row in rows if (row["stance"], row["way"]) == (stance, way)]
        mean = {
            key: float(np.mean([row[key] for row in own if row.get(key) is not None] or [np.nan]))
            for key in ("held", "false", "half_mm", "error_mm", *(f"seen_{low:g}_mm" for low in BINS[:-1]))
        }
        false = [row["false"] for row in own if row["false"] is not None]
        yield (
            f"{stance}, {way}, {len(own)} pairs: half band {mean['half_mm']:.1f} mm, 90 % of points within "
            f"{mean['error_mm']:.1f}, held {mean['held']:.0%}; unchanged points said {mean['false']:.1%}, pairs with "
            f"at most 10 %: {np.mean(np.array(false) <= 0.1):.0%} of {len(false)}"
        )
        yield "  seen: " + ", ".join(f"from {low:g} mm {mean[f'seen_{low:g}_mm']:.0%}" for low in BINS[:-1])
        yield f"  volume, ml: {_held(_changes_of_volume(own))}"
        for length in LENGTHS:
            yield f"  {length}, mm: {_held(_changes_of(own, length))}"
    for what, scores in (("points", rows), ("volume", _scores(_changes_of_volume(rows)))):
        yield f"factor of this half for {what}: {by_patient(scores, 'score', LEVEL):.2f}"
    for way in WAYS:
        lengths = [each for name in LENGTHS for each in _changes_of([r for r in rows if r["way"] == way], name)]
        yield f"likewise for lengths, {way}: {by_patient(_scores(lengths), 'score', LEVEL):.2f}"


Off = tuple[str, float, float, float]  # patient, error, half band, what half bands are in proportion to


def _changes_of_volume(rows: list[dict[str, Any]]) -> list[Off]:
    found = []
    for row in (row for row in rows if row["kind"] != "weight"):
        for s in (s for s in SIDES.values() if f"{s}_ml" in row):
            off, unit = row[f"{s}_ml"] - row[f"{s}_true_ml"], 0.1 * row[f"{s}_cm2"] * row[f"{s}_sigma_mm"]
            found.append((row["patient"], off, row[f"{s}_half_ml"], unit))
    return found


def _changes_of(rows: list[dict[str, Any]], length: str) -> list[Off]:
    found = []
    for row in rows:
        for side in (*SIDES.values(), "value"):
            half = row.get(f"{length}_{side}_half")
            if half is not None:
                found.append((row["patient"], row[f"{length}_{side}_error"], half, half))
    return found


def _scores(changes: list[Off]) -> list[dict[str, Any]]:
    return [{"patient": patient, "score": abs(off) / unit} for patient, off, _, unit in changes]


def _held(changes: list[Off]) -> str:
    if not changes:
        return "none"
    off, half = (np.array([each[k] for each in changes]) for k in (1, 2))
    median, most = np.quantile(np.abs(off), (0.5, LEVEL))
    return (
        f"off {median:.1f} (median), {most:.1f} (90 %), mean {off.mean():+.1f}, "
        f"half band {np.median(half):.1f}, held {np.mean(np.abs(off) <= half):.0%} of {len(off)}"
    )


def main(pairs: Path, table: Path, half: str) -> None:
    """Writes the table, and the summary to the terminal."""
    rig, rows = read_rig(default_rig_path()), list[dict[str, Any]]()
    for base in sorted(pairs.glob(f"*_{half}_*")):
        for way in WAYS:
            for kind in ("same", "volume", "dent", "weight"):
                rows += scored(rig, base, kind, way)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with table.open("w", newline="", encoding="utf-8") as file:
        lines = csv.DictWriter(file, columns)
        lines.writeheader()
        lines.writerows({k: round(v, 3) if isinstance(v, float) else v for k, v in row.items()} for row in rows)
    sys.stdout.write("\n".join(summary(rows)) + "\n")


if __name__ == "__main__":
    given = arguments(__doc__, "PAIRS", "TABLE", "HALF")
    main(Path(given.pairs), Path(given.table), given.half)
