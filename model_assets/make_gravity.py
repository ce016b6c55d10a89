"""Solves a cohort of women under gravity: `make cohort`, or python model_assets/make_gravity.py FOLDER [--women N].

Each is a woman of MakeHuman's adult dials on the model's template (virtual_patient/sampled.py), standing; her left
breast is brought to rest and laid on her back and her front (breastrig_studies/gravity).  One file a woman: a run that
was interrupted goes on where it was.  Needs the installed package and MakeHuman's data as build.py does.
`python -m breastrig_studies.gravity.estimate FOLDER` makes the model's data of them.
"""

import argparse
import os
import tomllib
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix
from steps.frame import reference_body
from steps.half_body import half_body
from steps.source import fetch, read_source
from steps.whole_body import whole_body
from threadpoolctl import threadpool_limits
from tqdm import tqdm
from virtual_patient.sampled import sampled
from virtual_patient.woman import vertices_of

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.gravity.solved import solved
from breastrig_studies.gravity.statics import NoEquilibrium

HERE = Path(__file__).resolve().parent
WOMEN = 400
STANDS_NOT = "not"  # suffix of the empty file of a woman who could not be solved


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="one file a woman goes here")
    parser.add_argument("--women", type=int, default=WOMEN, help=f"how many ({WOMEN})")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at a time (all cores)")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    recipe = tomllib.loads((HERE / "recipe.toml").read_text("utf-8"))
    wanted = recipe["source"]
    wheel = fetch(wanted["wheel"], wanted["requirement"], wanted["sha256"], HERE / "sources")
    source = read_source(wheel)
    body = reference_body(source, recipe["body"]["targets"])
    mix = whole_body(half_body(source, body, recipe), source.mirror, recipe["decimals"]).mix
    done = {int(file.stem) for file in options.folder.glob("[0-9]*[0-9].*")}
    left = [number for number in range(options.women) if number not in done]
    with ProcessPoolExecutor(options.jobs) as pool, tqdm(total=len(left), unit="woman") as bar:
        for _ in pool.map(partial(solve, wheel, body, mix, options.folder), left):
            bar.update()


def solve(wheel: Path, body: np.ndarray, mix: csr_matrix, folder: Path, number: int) -> None:
    """Writes NUMBER.npz, or NUMBER.not where her breast does not come to rest."""
    rig = read_rig(default_rig_path())
    vertices = rig.template + mix @ (vertices_of(read_source(wheel), sampled(number)) - body)
    try:
        with threadpool_limits(1):
            found = solved(rig, vertices, np.random.default_rng([number, 1]))
    except NoEquilibrium:
        (folder / f"{number:04d}.{STANDS_NOT}").touch()
        return
    part = folder / f"{number:04d}.part.npz"
    np.savez(part, **{name: values.astype(np.float32) for name, values in found.items()})
    part.replace(folder / f"{number:04d}.npz")


if __name__ == "__main__":
    main()
