"""Files of cuts, what `GET /api/scans/ID/cuts` answers: a fit made elsewhere then sees what the service's fits see."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan
from breastrig.core.private_files import read_ordinary, shown

LIMIT_BYTES = 1_000_000
MOST_CUTS = 32  # as many as the service keeps of one scan, and corners of one lasso
MOST_CORNERS = 300
BEYOND = 1e9  # no number of a cut is so large
WHAT = "a file of cuts is what GET /api/scans/ID/cuts answers"


def read_cuts(source: Path | Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
    """The cuts of a file, or of what it holds, as `hand_cuts.HandCut.of` reads them.  BadScan with one sentence."""
    document = _document(source) if isinstance(source, Path) else source
    cuts = document.get("cuts") if isinstance(document, Mapping) else None
    if not isinstance(cuts, list) or len(cuts) > MOST_CUTS:
        raise BadScan(f'There is no list "cuts" of at most {MOST_CUTS} in this file; {WHAT}.')
    return tuple(_checked(cut, place) for place, cut in enumerate(cuts, 1))


def _document(file: Path) -> Any:
    try:
        data = read_ordinary(file, LIMIT_BYTES)
        if len(data) > LIMIT_BYTES:
            raise BadScan(f"This file of cuts is larger than {LIMIT_BYTES // 10**6} MB; {WHAT}.")
        return json.loads(data)
    except OSError as error:
        name = shown(str(file))
        raise BadScan(f"The file of cuts {name} cannot be read ({error.strerror}); check the name.") from error
    except (ValueError, RecursionError) as error:
        raise BadScan(f"This file of cuts is not valid JSON; {WHAT}.") from error


def _checked(cut: Any, place: int) -> dict[str, Any]:
    try:
        picture, lasso = np.array(cut["to_picture"], dtype=float), np.array(cut["lasso"], dtype=float)
        is_formed = picture.shape == (16,) and lasso.ndim == 2 and lasso.shape[1] == 2
        if is_formed and 3 <= len(lasso) <= MOST_CORNERS and max(_largest(picture), _largest(lasso)) <= BEYOND:
            return {"to_picture": picture.tolist(), "lasso": lasso.tolist()}
    except (KeyError, TypeError, ValueError, OverflowError):
        pass
    needs = f"it needs 16 numbers to_picture and 3 to {MOST_CORNERS} corners"
    raise BadScan(f"Cut {place} of this file is none: {needs}; {WHAT}.")


def _largest(numbers: Array) -> float:
    """Their largest size; infinite where one is no number."""
    return float(np.abs(np.nan_to_num(numbers, nan=np.inf)).max())
