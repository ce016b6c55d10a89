"""A clinic's prior: sums over patients, no patient's row; a file `breastrig/prior@1` (decision 0027).

For each stance: the number of patients, and the sums of the posterior means of their scales and weights, of the means'
products and of the posterior covariances. Each patient's numbers are rounded to GRID, so that sums are exact: cohorts
may be merged in any order, and a removed patient leaves no trace.

So that no scan counts twice, each is identified by a hash of its file's hash, which contains nothing of a body: only
who has the scan can find out that it is included.
"""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from breastrig.core.arrays import Array
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.private_files import read_ordinary, shown
from breastrig.core.stances import Stance
from breastrig.rig.model import Rig

SCHEMA = "breastrig/prior@1"
KNOWN_AS = "cohort.json"  # among what is known of a rig (known.py)
FILE_BYTES = 5_000_000  # one of three stances has 600 thousand
GRID = 2.0**-36  # 1.5e-11: sums of numbers on it are exact below 2^17
LARGEST = 2.0**16
ROUNDING = 1e-12  # of the sum of squares, beyond the grid's


@dataclass(frozen=True, eq=False)
class Sums:
    """Sums over the patients of one stance; N = 3 B + S, the scales of all bones, then the weights."""

    women: int
    means: Array  # (N,)
    products: Array  # (N, N) of the means
    covariances: Array  # (N, N)
    scans: frozenset[str] = frozenset()  # a hash for each of them that is known (scan_hash)

    @staticmethod
    def of_woman(mean: Array, covariance: Array) -> "Sums":
        """The sums over one posterior, (N,) and (N, N)."""
        m, products, c = (np.round(each / GRID) * GRID for each in (mean, np.outer(mean, mean), covariance))
        return Sums(1, m, products, c)

    def plus(self, other: "Sums", sign: int = 1) -> "Sums":
        """The sums over both; with -1 the difference."""
        return Sums(
            self.women + sign * other.women,
            self.means + sign * other.means,
            self.products + sign * other.products,
            self.covariances + sign * other.covariances,
            self.scans | other.scans if sign > 0 else self.scans - other.scans,
        )

    @property
    def possible(self) -> bool:
        """Whether these can be sums over patients: no negative count or variance."""
        if self.women <= 0:
            return not (self.women or self.means.any() or self.products.any() or self.covariances.any())
        scatter = self.products - np.outer(self.means, self.means) / self.women
        rounding = self.women * len(self.means) * GRID + ROUNDING * float(np.trace(self.products))
        return all(np.linalg.eigvalsh(matrix)[0] > -rounding for matrix in (scatter, self.covariances))


@dataclass(frozen=True, eq=False)
class CohortPrior:
    """A cohort's sums for one rig, by stance."""

    rig_name: str
    rig_sha256: str
    bones: tuple[str, ...]
    shapes: tuple[str, ...]
    stances: Mapping[str, Sums]

    @property
    def women(self) -> int:
        """The number of scans, each of another patient or stance."""
        return sum(each.women for each in self.stances.values())

    @property
    def scans(self) -> frozenset[str]:
        """Hashes of the scans; fewer than `women` where an earlier version stored none."""
        return frozenset[str]().union(*(each.scans for each in self.stances.values()))

    def plus(self, other: "CohortPrior") -> "CohortPrior":
        """The sums over both; BadInput where they are of two rigs, or a scan is in both."""
        if other.rig_sha256 != self.rig_sha256:
            raise BadInput("These priors are of two different rigs; merge those of one.")
        twice = len(self.scans & other.scans)
        if twice:
            raise BadInput(
                f"Both priors hold {twice} of the same scans, and sums cannot be taken apart: take their fits out of "
                "one with `breastrig cohort remove`, or learn from all fits at once."
            )
        return replace(self, stances=self._changed(other.stances, 1))

    def without(self, other: "CohortPrior") -> "CohortPrior":
        """The prior without these patients; BadInput where they cannot have been in it."""
        if other.rig_sha256 != self.rig_sha256:
            raise BadInput("This fit is of another rig than the prior; it was never in it.")
        left = self._changed(other.stances, -1)
        unknown = len(other.scans - self.scans)
        if unknown > self.women - len(self.scans):
            raise BadInput("This fit is not in the prior; give a prior that was made with it.")
        if not all(sums.possible for sums in left.values()):
            raise BadInput("This fit is not in the prior; give a prior that was made with it.")
        return replace(self, stances={stance: sums for stance, sums in left.items() if sums.women})

    def _changed(self, others: Mapping[str, Sums], sign: int) -> dict[str, Sums]:
        size = 3 * len(self.bones) + len(self.shapes)
        none = Sums(0, np.zeros(size), np.zeros((size, size)), np.zeros((size, size)))
        both = sorted({*self.stances, *others})
        return {stance: self.stances.get(stance, none).plus(others.get(stance, none), sign) for stance in both}

    def content(self) -> bytes:
        """The bytes of the prior's file."""
        upper = np.triu_indices(3 * len(self.bones) + len(self.shapes))
        document: dict[str, Any] = {
            "schema": SCHEMA,
            "notice": LIMITS_OF_USE,
            "rig": {"name": self.rig_name, "sha256": self.rig_sha256},
            "bones": list(self.bones),
            "shapes": list(self.shapes),
            "stances": {
                stance: {"women": sums.women, "means": sums.means.tolist()}
                | ({"scans": sorted(sums.scans)} if sums.scans else {})
                | {"products": sums.products[upper].tolist(), "covariances": sums.covariances[upper].tolist()}
                for stance, sums in sorted(self.stances.items())
            },
        }
        return json_bytes(document)


def no_cohort(rig: Rig) -> CohortPrior:
    """An empty cohort."""
    return CohortPrior(rig.name, rig.sha256, rig.bone_names, rig.shape_names, {})


def scan_hash(sha256: str) -> str:
    """A scan's identifier in priors, 128 bits as hexadecimal digits; `sha256` is that of its file."""
    return hashlib.sha256(f"breastrig cohort {sha256}".encode()).hexdigest()[:32]


def cohort_of_scans(rig: Rig, scans: Iterable[tuple[str, str, Sums]]) -> CohortPrior:
    """The cohort of (patient, stance, sums).

    A scan counts once, under however many codes; a patient once in a stance, by the scan that leaves least uncertainty.
    """
    ordered = sorted(scans, key=lambda each: float(np.trace(each[2].covariances)))
    best: dict[tuple[str, str], Sums] = {}
    known: set[str] = set()
    for patient, stance, sums in ordered:
        if (patient, stance) not in best and not sums.scans & known:
            best[patient, stance] = sums
            known |= sums.scans
    nobody = no_cohort(rig)
    return reduce(CohortPrior.plus, (replace(nobody, stances={s: sums}) for (_, s), sums in best.items()), nobody)


def merged(priors: Sequence[CohortPrior]) -> tuple[CohortPrior, tuple[str, ...]]:
    """All priors added, and a sentence where it must be stated what counted; BadInput as `plus`.

    A prior whose patients are all in another one already counts once, the same file too.
    """
    whole, said = priors[0], []
    for other in priors[1:]:
        both = sorted((whole, other), key=lambda each: each.women)
        if _is_within(*both):
            whole = both[1]
            said.append(f"{both[0].women} of these scans are in both priors and count once.")
        else:
            whole = whole.plus(other)
    if any(len(each.scans) < each.women for each in priors):
        said.append(
            "A prior of an earlier version has no hashes of its scans: it is not known whether a "
            "patient is in two of them."
        )
    return whole, tuple(said)


def _is_within(part: CohortPrior, whole: CohortPrior) -> bool:
    if part.rig_sha256 != whole.rig_sha256:
        return False
    known = len(part.scans) == part.women and part.scans <= whole.scans
    return known or part.content() == whole.content()


Number = Annotated[FiniteFloat, Field(ge=-LARGEST, le=LARGEST)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _Rig(_Part):
    name: Annotated[str, Field(max_length=100)]
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class _Sums(_Part):
    women: Annotated[int, Field(ge=1, le=10_000_000)]
    means: list[Number]
    products: list[Number]
    covariances: list[Number]
    scans: list[Annotated[str, Field(pattern="^[0-9a-f]{32}$")]] = []


class _File(_Part):
    schema_: Literal["breastrig/prior@1"] = Field(alias="schema")
    notice: str = ""
    rig: _Rig
    bones: Annotated[list[str], Field(max_length=1000)]
    shapes: Annotated[list[str], Field(max_length=1000)]
    stances: dict[Stance, _Sums]


def parsed_prior(text: str | bytes, name: str) -> CohortPrior:
    """The prior of a file's text; BadInput where it is none, `name` is shown."""
    try:
        found = _File.model_validate_json(text)
    except (ValidationError, RecursionError) as error:
        faults = error.errors(include_url=False, include_input=False) if isinstance(error, ValidationError) else []
        where = ".".join(map(str, faults[0]["loc"])) if faults else ""
        where = where or "it is no JSON of that kind"
        raise BadInput(f"{name} is no prior that `breastrig cohort` wrote ({where}); make it again.") from error
    size = 3 * len(found.bones) + len(found.shapes)
    stances = {}
    for stance, each in found.stances.items():
        lengths = len(each.means), len(each.products), len(each.covariances)
        upper = size * (size + 1) // 2
        sums = (
            Sums(
                each.women,
                np.array(each.means),
                _square(each.products, size),
                _square(each.covariances, size),
                frozenset(each.scans),
            )
            if lengths == (size, upper, upper) and len(set(each.scans)) == len(each.scans) <= each.women
            else None
        )
        if sums is None or not sums.possible:
            raise BadInput(f"{name} does not hold together ({stance}): no bodies have such sums; make it again.")
        stances[str(stance)] = sums
    return CohortPrior(found.rig.name, found.rig.sha256, tuple(found.bones), tuple(found.shapes), stances)


def _square(upper: list[float], size: int) -> Array:
    """(N, N), symmetric."""
    matrix = np.zeros((size, size))
    matrix[np.triu_indices(size)] = upper
    return matrix + np.triu(matrix, 1).T


def read_prior(file: Path) -> CohortPrior:
    """The prior of a file; BadInput where it cannot be read or is none."""
    try:
        content = read_ordinary(file, FILE_BYTES)
    except OSError as error:
        raise BadInput(f"The prior {shown(file)} cannot be read; check the file.") from error
    if len(content) > FILE_BYTES:
        raise BadInput(f"The prior {shown(file)} is larger than {FILE_BYTES // 10**6} MB; it is none.")
    return parsed_prior(content, shown(file))


def with_prior(rig: Rig, prior: CohortPrior) -> Rig:
    """The rig with this cohort as known data, or itself where that is empty. BadInput for another rig's prior."""
    if prior.rig_sha256 != rig.sha256 or (prior.bones, prior.shapes) != (rig.bone_names, rig.shape_names):
        raise BadInput(f"This prior is of another rig ({prior.rig_name}); make one of fits with {rig.name} as it is.")
    return _with_text(rig, prior.content().decode()) if prior.women else rig


@lru_cache(maxsize=4)  # the same object each time: what is derived from a rig is kept with it
def _with_text(rig: Rig, text: str) -> Rig:
    return replace(rig, known={**rig.known, KNOWN_AS: text})


@lru_cache(maxsize=8)
def cohort_of(rig: Rig) -> CohortPrior | None:
    """The cohort that is known with this rig."""
    text = rig.known.get(KNOWN_AS)
    return None if text is None else parsed_prior(text, KNOWN_AS)
