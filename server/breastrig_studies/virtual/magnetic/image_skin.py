"""How far the skin found in MR images is from the true one, over what spoils images.

Images of made women (virtual/magnetic); thresholds were chosen on the seeds 0 to 9, these are others.
"""

import sys
import time
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_areas
from breastrig.scan.images.skin.skin_of_image import ImageSkin, skin_of_image
from breastrig_studies.arguments import arguments
from breastrig_studies.virtual.magnetic.image import OPTIONS, PLAIN, MrImage, mr_image
from breastrig_studies.virtual.magnetic.woman import prone_woman

SEEDS = (20, 21, 22)
STEPS = (1.0, 1.0, 1.0)  # mm
LARGE, LARGE_STEPS = 2, (0.8, 0.8, 1.0)  # seed and mm of the image whose time and memory are measured
ARMS = "arms touch"
PLACES, FAR, WITHIN = 40_000, 3.0, 4.0  # on each skin; mm: false or missed; voxels from the image's ends
HEADS = ("image", "mean", "95 %", "worst", "false %", "missed %", "nipples", "worst of them", "seen")


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


def row(name: str, found: list[Found]) -> str:
    """One row of the table."""
    skin, missed = (np.concatenate([getattr(each, part) for each in found]) for part in ("skin", "missed"))
    nipples = [each for one in found for each in one.nipples]
    cells = [name, f"{skin.mean():.2f}", f"{np.percentile(skin, 95):.2f}", f"{skin.max():.1f}"]
    cells += [f"{100.0 * (skin > FAR).mean():.2f}", f"{100.0 * (missed > FAR).mean():.2f}"]
    cells += [f"{np.mean(nipples):.1f}", f"{max(nipples):.1f}"] if nipples else ["–", "–"]
    return "| " + " | ".join([*cells, f"{len(nipples)} of {sum(each.shown for each in found)}"]) + " |\n"


def main() -> None:
    """Writes the table, and what a full image costs."""
    sys.stdout.write(f"| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}\n")
    for name in (*OPTIONS, ARMS):
        found = []
        for seed in SEEDS:
            woman = prone_woman(seed, "beside" if name == ARMS else "raised")
            protocol = OPTIONS.get(name, OPTIONS["plain"])(replace(PLAIN, steps=STEPS))
            made = mr_image(woman, protocol, seed)
            found.append(found_in(made, skin_of_image(made.image)))
        sys.stdout.write(row(name, found))
        sys.stdout.flush()
    made = mr_image(prone_woman(LARGE), replace(PLAIN, steps=LARGE_STEPS, back=True), LARGE)
    began = time.perf_counter()
    skin_of_image(made.image)
    took = time.perf_counter() - began
    size = " x ".join(map(str, made.image.values.shape))
    sys.stdout.write(f"\n{size} voxels: {took:.1f} s\n")


if __name__ == "__main__":
    arguments(__doc__)
    main()
