"""How far is the skin found in MR images from the true one, over what spoils images?

python -m breastrig_studies.virtual.magnetic.image_skin TABLE.csv MM SEED [SEED ...]

Images of made women (virtual/magnetic), voxels of MM, a woman a seed; one row a kind of image.  Thresholds were
chosen on the seeds 0 to 9 and 40 to 45.
"""

import csv
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_areas
from breastrig.scan.images.skin.skin_of_image import ImageSkin, skin_of_image
from breastrig_studies.arguments import arguments
from breastrig_studies.virtual.magnetic.image import OPTIONS, PLAIN, MrImage, mr_image
from breastrig_studies.virtual.magnetic.woman import prone_woman

ARMS = "arms touch"
PLACES, FAR, WITHIN = 40_000, 3.0, 4.0  # on each skin; mm: false or missed; voxels from the image's ends
HEADS = (
    *("image", "women", "mean_mm", "p95_mm", "worst_mm", "false_percent", "missed_percent"),
    *("nipples_mean_mm", "nipples_worst_mm", "nipples_seen", "nipples_shown"),
)


@dataclass(frozen=True)
class Found:
    """Of one image; distances in mm."""

    skin: Array  # (N,) from the skin found to the true one
    missed: Array  # (N,) from the true skin within the image to the one found
    nipples: tuple[float, ...]
    shown: int  # nipples within the image


def places_on(vertices: Array, faces: Integers, count: int, random: np.random.Generator) -> Array:
    """(count, 3) evenly over the skin."""
    areas = face_areas(vertices, faces)
    chosen, shares = random.choice(len(faces), count, p=areas / areas.sum()), random.random((count, 2))
    root = np.sqrt(shares[:, :1])
    weights = np.concatenate([1.0 - root, root * (1.0 - shares[:, 1:]), root * shares[:, 1:]], axis=1)
    return np.asarray(np.einsum("nk,nkc->nc", weights, vertices[faces[chosen]]))


def found_in(made: MrImage, skin: ImageSkin) -> Found:
    """The skin compared with the truth."""
    random, image = np.random.default_rng(1), made.image
    ours = places_on(skin.vertices, skin.faces, PLACES, random)
    true = places_on(made.vertices, made.faces, 4 * PLACES, random)
    at = np.linalg.solve(image.affine[:3, :3], (true - image.affine[:3, 3]).T).T
    inside = ((at > WITHIN) & (at < np.array(image.values.shape) - 1 - WITHIN)).all(axis=1)
    for gap in image.gaps:
        inside &= (at[:, gap.axis] < gap.first - WITHIN) | (at[:, gap.axis] > gap.last + WITHIN)
    ends = image.affine[0, 3] + image.affine[0, 0] * np.array([0, image.values.shape[0] - 1])
    return Found(
        ClosestPointSearch(made.vertices, made.faces).query(ours).distances,
        ClosestPointSearch(skin.vertices, skin.faces).query(true[inside]).distances,
        tuple(float(np.linalg.norm(each.place - made.nipples[each.side])) for each in skin.nipples),
        sum(bool(ends[0] < place[0] < ends[1]) for place in made.nipples.values()),
    )


def row(name: str, found: list[Found]) -> dict[str, str | int]:
    """The numbers of one kind of image, by HEADS."""
    skin, missed = (np.concatenate([getattr(each, part) for each in found]) for part in ("skin", "missed"))
    nipples = [each for one in found for each in one.nipples]
    cells = [f"{skin.mean():.2f}", f"{np.percentile(skin, 95):.2f}", f"{skin.max():.1f}"]
    cells += [f"{100.0 * (skin > FAR).mean():.2f}", f"{100.0 * (missed > FAR).mean():.2f}"]
    cells += [f"{np.mean(nipples):.1f}", f"{max(nipples):.1f}"] if nipples else ["", ""]
    counts = (len(nipples), sum(each.shown for each in found))
    return dict(zip(HEADS, (name, len(found), *cells, *counts), strict=True))


def main(table: Path, step: float, seeds: Sequence[int]) -> None:
    """Writes the table anew after each woman."""
    found: dict[str, list[Found]] = {name: [] for name in (*OPTIONS, ARMS)}
    for seed in seeds:
        for name, those in found.items():
            woman = prone_woman(seed, "beside" if name == ARMS else "raised")
            protocol = OPTIONS.get(name, OPTIONS["plain"])(replace(PLAIN, steps=(step, step, step)))
            made = mr_image(woman, protocol, seed)
            those.append(found_in(made, skin_of_image(made.image)))
            sys.stdout.write(f"{seed}, {name}\n")
        with table.open("w", encoding="utf-8", newline="") as file:
            out = csv.DictWriter(file, HEADS, lineterminator="\n")
            out.writeheader()
            out.writerows(row(name, those) for name, those in found.items())


if __name__ == "__main__":
    given = arguments(__doc__, "TABLE", "MM", "SEED...")
    main(Path(given.table), float(given.mm), [int(each) for each in given.seed])
