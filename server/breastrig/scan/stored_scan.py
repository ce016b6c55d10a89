"""The service's copy of an uploaded scan: triangles, colours and picture, none of the file's names and comments.

A numpy .npz without pickled objects, exact to the last bit; the sha256 is that of the uploaded bytes.
"""

import json
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.errors import BadScan
from breastrig.scan.pictures.texture import written_anew
from breastrig.scan.piece import BallInside, SeenLandmark
from breastrig.scan.scan import Scan
from breastrig.scan.true_size import kept_size

STORED = "stored"  # the file type, for which no upload can pass
FACTS = ("unit", "metres_per_unit", "unit_reason", "sha256", "notes", "from_points")
OF_VOLUMES = ("from_label_map", "from_image")


def write_stored(scan: Scan, path: Path) -> None:
    """Writes the scan to the file `path`.  Raises OSError."""
    facts = {name: getattr(scan, name) for name in FACTS}
    if not scan.size_known:
        facts["size_known"] = False
    if scan.in_patient_frame:
        facts |= {name: getattr(scan, name) for name in OF_VOLUMES}
        facts["stated_stance"] = scan.stated_stance
        facts["seen"] = [[each.name, each.place.tolist(), each.radius] for each in scan.seen]
        facts["lesions"] = [[each.name, each.center.tolist(), each.radius] for each in scan.lesions]
    arrays: dict[str, NDArray[Any]] = {
        "facts": np.frombuffer(json.dumps(facts).encode(), np.uint8),
        "vertices": scan.vertices,
        "faces": scan.faces.astype(np.int32),
    }
    if scan.colours is not None:
        arrays["colours"] = scan.colours
    if scan.wall is not None:
        arrays["wall_vertices"], arrays["wall_faces"] = scan.wall
    if scan.uv is not None and scan.picture is not None:
        arrays |= {"uv": scan.uv, "picture": np.frombuffer(scan.picture, np.uint8)}
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def read_stored(path: Path, texture: bool = True, for_display: bool = True) -> Scan:
    """The scan that `write_stored` wrote; no picture if not `texture`, the original one if not `for_display`.

    It has its true size where a length is kept beside it.  BadScan when it is damaged.
    """
    scan, size = _read(path, texture, for_display), kept_size(path.parent)
    return scan if size is None else scan.in_true_size(size)


def _read(path: Path, texture: bool, for_display: bool) -> Scan:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            facts = json.loads(arrays["facts"].tobytes())
            painted = texture and "picture" in arrays
            picture = arrays["picture"].tobytes() if painted else None
            jpeg = picture if picture is None or not for_display else written_anew(picture)
            return Scan(
                vertices=arrays["vertices"],
                faces=arrays["faces"],
                colours=arrays.get("colours"),
                uv=arrays["uv"] if jpeg is not None else None,
                texture=jpeg,
                picture=None if jpeg is None else picture,
                **{name: facts[name] for name in FACTS} | {"notes": tuple(facts["notes"])},
                **{name: facts.get(name, False) for name in OF_VOLUMES},
                size_known=facts.get("size_known", True),
                stated_stance=facts.get("stated_stance"),
                seen=tuple(SeenLandmark(name, np.array(at), r) for name, at, r in facts.get("seen", [])),
                wall=(arrays["wall_vertices"], arrays["wall_faces"]) if "wall_faces" in arrays else None,
                lesions=tuple(BallInside(name, np.array(at), r) for name, at, r in facts.get("lesions", [])),
            )
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise BadScan("The stored scan is damaged; upload it again.") from error
