"""Counts the work of tasks, one after the other in a process of its own: `python -m helpers.counted_work` prints JSON.

What is counted does not depend on the machine's speed: calls of the few operations that cost the most, and modules.
"""

import json
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from functools import cached_property, wraps
from importlib import import_module
from pathlib import Path
from typing import Any

from breastrig.core.assets import asset_folder

EXAMPLE = asset_folder("example") / "standing"
NOT_NEEDED = (  # by a fit of a mesh without pictures
    *(
        "scipy.ndimage",
        "skimage",
        "PIL",
        "trimesh",
        "flask",
        "apiflask",
        "dask",
        "distributed",
    ),
    *("typst", "matplotlib", "nibabel", "pydicom", "pxr"),
)

counts: Counter[str] = Counter()
made: list[Any] = []  # the fit of `second_fit`


def _counting(what: str, function: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(function)
    def counted(*given: Any, **named: Any) -> Any:
        counts[what] += 1
        return function(*given, **named)

    return counted


def _count_method(what: str, owner: type, name: str) -> None:
    found = vars(owner)[name]
    if isinstance(found, cached_property):
        counting = cached_property(_counting(what, found.func))
        counting.__set_name__(owner, name)
        setattr(owner, name, counting)
    else:
        setattr(owner, name, _counting(what, found))


def _count_everywhere(what: str, function: Callable[..., Any]) -> None:
    """In every module of the package that has imported it by its name."""
    counting = _counting(what, function)
    for module in [each for name, each in sys.modules.items() if name.startswith("breastrig")]:
        for name, value in list(vars(module).items()):
            if value is function:
                setattr(module, name, counting)


def count_from_here() -> None:
    """Wraps the operations; what a task needs has to be imported before."""
    import daqp
    import scipy.linalg.lapack
    from scipy.linalg import solveh_banded
    from scipy.spatial import cKDTree

    from breastrig.correspondence.match import match
    from breastrig.fitting.fit import ScanProblem
    from breastrig.geometry.closest_point import ClosestPointSearch
    from breastrig.geometry.rays import RayCaster
    from breastrig.least_squares.newton import assemble
    from breastrig.rig.skinning import Posed, PosedByDualQuaternions
    from breastrig.scan.clean import clean
    from breastrig.scan.read import read_scan

    for owner in (Posed, PosedByDualQuaternions):
        if "vertices" in vars(owner):
            _count_method("posings", owner, "vertices")
    _count_method("closest_point_trees", ClosestPointSearch, "__init__")
    _count_method("closest_point_queries", ClosestPointSearch, "query")
    _count_method("closest_point_queries", ClosestPointSearch, "distances")
    _count_method("ray_scenes", RayCaster, "__init__")
    _count_method("problems", ScanProblem, "__init__")
    scipy.linalg.lapack.dpotrf = _counting("factorisations", scipy.linalg.lapack.dpotrf)
    daqp.solve = _counting("quadratic_programs", daqp.solve)
    for what, function in {
        "matches": match,
        "systems": assemble,
        "point_trees": cKDTree,
        "banded_systems": solveh_banded,
        "scans_cleaned": clean,
        "scans_read": read_scan,
    }.items():
        _count_everywhere(what, function)


def command(folder: Path) -> None:
    """`breastrig fit` of the example with its landmarks."""
    from breastrig.cli.main import main

    import_module("breastrig.cli.fit_command")
    count_from_here()
    scan, picks = EXAMPLE / "scan.ply", EXAMPLE / "landmarks.json"
    assert main(["fit", str(scan), "--landmarks", str(picks), "-o", str(folder / "out")]) == 0
    counts["modules_of_breastrig"] = sum(each.startswith("breastrig.") for each in sys.modules)
    counts["modules"] = len(sys.modules)
    counts["libraries_not_needed"] = sum(each in sys.modules for each in NOT_NEEDED)


def second_fit(folder: Path) -> None:
    """The second `breastrig.fit` of a program, or the second row of a batch, with its files."""
    import breastrig

    counts.clear()
    made.append(breastrig.fit(EXAMPLE / "scan.ply", EXAMPLE / "landmarks.json"))
    made[0].save(folder / "second")


def drag(folder: Path) -> None:
    """One position of a landmark that is dragged, after the first."""
    from breastrig.gltf.pose_nodes import node_poses
    from breastrig.scan.landmarks.landmark_files import read_landmarks
    from breastrig.use.moving.moved_landmarks import follow_landmarks, moved_landmarks
    from breastrig.use.steps.settings import EarlierFit, FitJob

    (fit,) = made
    places, _ = read_landmarks(EXAMPLE / "landmarks.json")
    picks = {name: [float(x) for x in place] for name, place in places.items()}
    found = fit.in_metres
    earlier = EarlierFit(fit.stance, node_poses(found.rig, found.parameters), found.rig.sha256)
    job = FitJob(EXAMPLE / "scan.ply", folder, picks, stance=fit.stance, drawing=None, earlier=earlier)
    follow_landmarks("fit", job, (), picks)
    counts.clear()
    picks["nipple_L"][0] += 4.0
    assert moved_landmarks("fit", picks) is not None


def upload(folder: Path) -> None:
    """What a service does with an uploaded scan, in a process that has the model ready."""
    from breastrig.use.read_upload import UploadJob, read_upload

    counts.clear()
    names = {each: folder / each for each in ("kept", "mesh", "thumbnail", "volume")}
    read_upload(UploadJob(scan=EXAMPLE / "scan.ply", units="auto", triangles=10**6, **names))


TASKS = {each.__name__: each for each in (command, second_fit, drag, upload)}  # in this order


def main() -> None:
    done = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, task in TASKS.items():
            task(Path(folder))
            done[name] = dict(counts)
    sys.stdout.write(json.dumps(done) + "\n")


if __name__ == "__main__":
    main()
