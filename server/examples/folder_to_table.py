"""A folder of scans into a table.

One row a scan, with its verdict, distances and breast measures: `python folder_to_table.py scans/ table.csv`,
or the packaged patient's two scans without arguments. A scan with a landmark file of the same name beside it
(a.ply, a.json) is fitted with that; what cannot be fitted gets a row with the reason. (`breastrig batch` does
many scans on all cores and goes on where it was interrupted.)
"""

import csv
import sys
from pathlib import Path

import breastrig

SCANS = (".ply", ".obj", ".stl", ".glb", ".usdz", ".off", ".3mf", ".zip", ".nii", ".gz", ".dcm")  # MRI label maps last
MEASURES = ("notch_nipple", "nipple_fold", "base_width", "volume")
COLUMNS = ("scan", "stance", "verdict", "mean_mm", *(f"{name}_{side}" for name in MEASURES for side in "LR"), "problem")


def row_of(file: Path, model: breastrig.Rig) -> dict[str, object]:
    """The numbers of one scan, or what is wrong with it."""
    picked = file.with_suffix(".json")
    try:
        fit = breastrig.fit(file, picked if picked.is_file() else None, drawing=None, model=model)
    except breastrig.BreastRigError as error:
        return {"scan": file.name, "problem": str(error)}
    row: dict[str, object] = {"scan": file.name, "stance": fit.stance, "verdict": fit.verdict.level}
    row["mean_mm"] = fit.result["surface_distance_mm"]["mean"]
    row["problem"] = " ".join(fit.verdict.reasons)
    for each in breastrig.measure(fit):
        if each.name in MEASURES and each.kind in ("straight", "volume"):
            for side, number in (("L", each.left), ("R", each.right)):
                row[f"{each.name}_{side}"] = None if number is None else round(number.value, 1)  # mm or ml
    return row


def main(folder: str, table: str) -> None:
    model = breastrig.load_model()  # once for all
    scans = sorted(file for file in Path(folder).iterdir() if file.suffix.lower() in SCANS)
    with open(table, "w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, COLUMNS)
        writer.writeheader()
        for file in scans:
            row = row_of(file, model)
            writer.writerow(row)
            print(row["scan"], row.get("verdict", "failed"))


if __name__ == "__main__":
    if len(sys.argv) == 3:
        main(*sys.argv[1:])
    else:
        main(str(breastrig.example("standing").scan.parent), "folder_to_table.csv")
