"""Writes gravity.json (volume/predicted.py), its first way, from solved bodies: `make cohort`, then

python -m breastrig_studies.gravity.estimate FOLDER

Bodies are split by their numbers: half of them (development) estimate the Gaussian, a quarter (validation) chooses its
band, a quarter (test) is only measured.
"""

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.volume.breast_skin import BreastSkin, breast_skins
from breastrig.volume.predicted import (
    FILE,
    SCHEMA,
    STANCES,
    TENTH,
    GravityPrior,
    Way,
    gravity_prior,
    in_template,
    lying,
)
from breastrig_studies.arguments import arguments

PLACE = default_rig_path().with_suffix(".known") / FILE
FACTORS = 12
OBSERVATION = 0.06  # m, of each of hundreds of vertices whose errors are not independent (docs/decisions/0020)
POSTURE = 0.012  # m, 90 %: where two ways of computing a lying body have the same breast (docs/decisions/0020)
HELD = 0.9


@dataclass(frozen=True, eq=False)
class Woman:
    """The left breast's P vertices, heights over its sheet (m) by stance."""

    number: int
    heights: dict[str, Array]  # (P * 3,)

    @property
    def part(self) -> str:
        return ("development", "validation", "development", "test")[self.number % 4]


def read_women(rig: Rig, folder: Path) -> tuple[Woman, ...]:
    """The bodies in the files that make_gravity.py wrote."""
    left, _ = breast_skins(rig)
    return tuple(_woman(rig, left, file) for file in sorted(folder.glob("[0-9]*[0-9].npz")))


def _woman(rig: Rig, left: BreastSkin, file: Path) -> Woman:
    found = {name: np.asarray(values, dtype=np.float64) for name, values in np.load(file).items()}
    local, turn = in_template(rig, found["given"])
    standing = left.heights(local)
    moves = {"standing": 0.0} | {name: found[f"{name}_skin"] @ turn.T for name in STANCES[1:]}
    return Woman(int(file.stem), {name: (standing + move).ravel() for name, move in moves.items()})


def gaussian(women: Sequence[Woman], factors: int = FACTORS, observation: float = OBSERVATION) -> Way:
    """Mean and strongest factors of all stances together; motions count as much as shapes, which vary more."""
    stances = tuple(women[0].heights)
    rows = {name: np.array([woman.heights[name] for woman in women]) for name in stances}
    mean = {name: found.mean(axis=0) for name, found in rows.items()}
    shape = rows["standing"] - mean["standing"]
    moves = [rows[name] - rows["standing"] - mean[name] + mean["standing"] for name in stances[1:]]
    weight = np.sqrt((shape**2).sum() / sum((move**2).sum() for move in moves))
    _, sizes, ways = np.linalg.svd(np.hstack([shape, *(weight * move for move in moves)]), full_matrices=False)
    kept = sizes[:factors, None] * ways[:factors] / np.sqrt(len(women))
    standing, *moved = np.split(kept, len(stances), axis=1)
    by_stance = {"standing": standing}
    by_stance |= {name: standing + move / weight for name, move in zip(stances[1:], moved, strict=True)}
    return Way(mean, by_stance, observation, len(women))


def misses(prior: GravityPrior, women: Sequence[Woman], stance: str, goal: str) -> tuple[Array, Array]:
    """((W, P) m: how far each vertex is from where it was predicted, (W, P) m its radius)."""
    found = []
    for woman in women:
        move, radii = prior.moved(woman.heights[stance], stance, goal)
        true = (woman.heights[goal] - woman.heights[stance]).reshape(-1, 3)
        found.append((np.linalg.norm(move - true, axis=1), radii))
    return np.array([miss for miss, _ in found]), np.array([radius for _, radius in found])


def with_band(way: Way, women: Sequence[Woman], breast: Booleans) -> GravityPrior:
    """That way alone, with the band that holds nine of ten of the (P,) bool `breast` vertices of the bodies."""
    prior = GravityPrior((way,), 1.0, POSTURE)
    ratios = [np.divide(*(each[:, breast] for each in misses(prior, women, "standing", goal))) for goal in STANCES[1:]]
    return replace(prior, band=float(np.quantile(np.concatenate(ratios), HELD)))


def with_lying_mean(rig: Rig, way: Way) -> Way:
    """With the mean of lying breasts from bodies known in both stances by two ways of computing.

    The cohort, whose stiffness is drawn, gives the variation about that mean (decision 0008).
    """
    trunk, whole = lying(rig)
    supine = way.mean["standing"] + (whole - trunk)[breast_skins(rig)[0].skin].ravel()
    return replace(way, mean={**way.mean, "supine": supine})


def document(prior: GravityPrior) -> dict[str, Any]:
    """The prior as the file's document."""

    def whole(values: Array) -> Any:
        return np.rint(values / TENTH).astype(int).tolist()

    return {
        "schema": SCHEMA,
        "band": round(prior.band, 3),
        "posture_mm": 1e3 * prior.posture,
        "ways": [
            {
                "women": way.women,
                "observation_mm": 1e3 * way.observation,
                "mean": {name: whole(values) for name, values in way.mean.items()},
                "factors": {name: whole(values) for name, values in way.factors.items()},
            }
            for way in prior.ways
        ],
    }


def write(prior: GravityPrior, file: Path) -> None:
    """Writes the file."""
    file.write_text(json.dumps(document(prior), separators=(",", ":")) + "\n", "utf-8")


def main(folder: Path, file: Path = PLACE) -> None:
    """Estimates, prints how far off the test set is, and writes the file."""
    rig = read_rig(default_rig_path())
    women = read_women(rig, folder)
    parts = {name: [woman for woman in women if woman.part == name] for name in ("development", "validation", "test")}
    breast = breast_skins(rig)[0].breast
    prior = with_band(gaussian(parts["development"]), parts["validation"], breast)
    for stance, goal in (("standing", "supine"), ("standing", "prone"), ("prone", "supine"), ("supine", "standing")):
        miss, radii = (each[:, breast] for each in misses(prior, parts["test"], stance, goal))
        still = [
            np.linalg.norm((w.heights[goal] - w.heights[stance]).reshape(-1, 3)[breast], axis=1) for w in parts["test"]
        ]
        sys.stdout.write(
            f"{stance} -> {goal}: {1e3 * miss.mean():.1f} mm mean, {1e3 * np.quantile(miss, 0.95):.1f} mm 95 %, "
            f"{(miss <= radii).mean():.0%} within their radii; not moved {1e3 * np.mean(still):.1f} mm\n"
        )
    known = gravity_prior(rig)
    others = () if known is None else known.ways[1:]  # two_stances.py
    write(replace(prior, ways=(replace(with_lying_mean(rig, prior.ways[0]), women=len(women)), *others)), file)


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER", "[FILE]")
    main(Path(given.folder), Path(given.file or PLACE))
