"""Reads USD in a process of its own, with limits of memory and time, wherever the scan itself is read.

A crate of a kilobyte can ask Pixar's library for any amount of memory, and a damaged one can end the process that reads
it: neither must happen to a program that only wanted to open a file.  `python -m breastrig.scan.formats.usd_process` is
the other side: the file comes in, arrays in numpy's .npz without pickled objects go out, or a sentence.
"""

import contextlib
import importlib.util
import io
import json
import subprocess
import sys
import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.scan.limits import USD_MEMORY, USD_SECONDS
from breastrig.scan.piece import Piece, Pieces

WITHOUT_LIBRARY = 'This is a USD file; install "breastrig[formats]", or export the scan as GLB, PLY or OBJ.'
TOO_MUCH = "This USD file is damaged, or asks for more memory or time than it may; export the scan as GLB, PLY or OBJ."
REFUSALS: dict[str, type[BadInput]] = {each.__name__: each for each in (BadScan, TooLarge)}
ARRAYS = ("vertices", "faces", "colours", "uv")


def usd_pieces(data: bytes, texture: bool) -> Pieces:
    """The scene's meshes, +Y up. Raises BadScan or TooLarge with a sentence."""
    if importlib.util.find_spec("pxr") is None:
        raise BadScan(WITHOUT_LIBRARY)
    command = [sys.executable, "-m", __name__, *(["--texture"] if texture else [])]
    try:
        done = subprocess.run(command, input=data, capture_output=True, timeout=2 * USD_SECONDS, check=False)
        if done.returncode != 0:
            raise ValueError("it was ended")
        return _unpacked(done.stdout)
    except (subprocess.TimeoutExpired, OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        raise BadScan(TOO_MUCH) from error


def _packed(found: Pieces) -> bytes:
    arrays: dict[str, NDArray[Any]] = {}
    pictures = list(dict.fromkeys(piece.picture for piece in found.pieces if piece.picture is not None))
    for number, piece in enumerate(found.pieces):
        for name in ARRAYS:
            values = getattr(piece, name)
            if values is not None:
                arrays[f"{number} {name}"] = values
    for number, picture in enumerate(pictures):
        arrays[f"picture {number}"] = np.frombuffer(picture, np.uint8)
    whose = [None if piece.picture is None else pictures.index(piece.picture) for piece in found.pieces]
    facts = json.dumps(
        {
            "pictures": whose,
            "tints": [piece.tint for piece in found.pieces],
            "notes": found.notes,
            "unit": found.unit,
            "by_default": found.unit_by_default,
        }
    ).encode()
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, facts=np.frombuffer(facts, np.uint8), **arrays)
    return stream.getvalue()


def _unpacked(answer: bytes) -> Pieces:
    if answer.startswith(b"{"):
        refusal = json.loads(answer)
        raise REFUSALS[refusal["kind"]](refusal["sentence"])
    with np.load(io.BytesIO(answer), allow_pickle=False) as arrays:
        facts = json.loads(arrays["facts"].tobytes())
        pictures: dict[int, bytes] = {}
        pieces = []
        for number, (picture, tint) in enumerate(zip(facts["pictures"], facts["tints"], strict=True)):
            if picture is not None and picture not in pictures:
                pictures[picture] = arrays[f"picture {picture}"].tobytes()
            values = {name: arrays[f"{number} {name}"] for name in ARRAYS if f"{number} {name}" in arrays}
            shown = None if picture is None else pictures[picture]
            pieces.append(Piece(**values, picture=shown, tint=None if tint is None else tuple(tint)))
    return Pieces(tuple(pieces), notes=tuple(facts["notes"]), unit=facts["unit"], unit_by_default=facts["by_default"])


def main() -> None:
    """The child process: sets its limits, then reads with the library."""
    with contextlib.suppress(ImportError, ValueError, OSError):  # systems without such limits
        import resource

        for limit, most in ((resource.RLIMIT_AS, USD_MEMORY), (resource.RLIMIT_CPU, USD_SECONDS)):
            _, hard = resource.getrlimit(limit)
            resource.setrlimit(limit, (most if hard < 0 else min(most, hard), hard))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a core file would show the patient
    from breastrig.scan.formats import usd

    try:
        answer = _packed(usd.usd_pieces(sys.stdin.buffer.read(), "--texture" in sys.argv))
    except BadInput as error:
        kind = next((name for name, each in REFUSALS.items() if type(error) is each), BadScan.__name__)
        answer = json.dumps({"kind": kind, "sentence": str(error)}).encode()
    sys.stdout.buffer.write(answer)


if __name__ == "__main__":
    main()
