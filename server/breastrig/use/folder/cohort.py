"""Priors from folders of fits (decision 0027)."""

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from breastrig.cases.documents import FitDocument, read_document
from breastrig.cases.fits import is_of_other_size
from breastrig.cases.layout import FIT
from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadInput
from breastrig.core.private_files import read_ordinary
from breastrig.files.result import BODY, RESULT, ResultFile, folder_name
from breastrig.fitting.posterior import parsed_contribution
from breastrig.rig.cohort_prior import CohortPrior, Sums, cohort_of_scans, scan_hash
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import checked_result

BODY_BYTES = 10_000_000  # the torso's has 14 thousand


@dataclass(frozen=True, eq=False)
class Cohort:
    """The prior from folders of fits."""

    prior: CohortPrior
    others: tuple[str, ...]  # a sentence for each kind of fits that do not count


def cohort_in(folders: Sequence[Path], rig: Rig, with_example: bool = False) -> Cohort:
    """All fits in these folders; of a patient who was scanned several times in a stance the one that shows most.

    A scan counts once, under however many codes.  The package's example is nobody's patient: it does not count.

    Raises BadInput for a folder without any, and for fits of another rig.
    """
    scans: list[tuple[str, str, Sums]] = []
    silent = unusable = unchecked = examples = resized = 0
    files: set[str] = set()
    for place in _fits(folders):
        result = checked_result(place)
        if result.model.sha256 != rig.sha256:
            raise BadInput(
                f"{folder_name(place)} was fitted with another model ({result.model.name}); give that model."
            )
        if result.predicted or (result.verdict is not None and result.verdict.level == "unusable"):
            unusable += 1
            continue
        if _is_of_other_size(place):
            resized += 1
            continue
        if not with_example and result.scan.sha256 in example_scans():
            examples += 1
            continue
        sums = _sums(place, rig, result)
        if sums is None:
            silent += 1
        else:
            unchecked += not result.files
            files.add(result.scan.sha256)
            known = replace(sums, scans=frozenset({scan_hash(result.scan.sha256)}))
            scans.append((_patient(place, result), result.stance, known))
    prior = cohort_of_scans(rig, scans)
    said = (
        (len(scans) - len(files), "the same scan again"),
        (len(files) - prior.women, "another scan of the same patient in the same stance shows more"),
        (examples, "the package's example, which is nobody's patient"),
        (unusable, "not usable, or predicted"),
        (resized, "the scan has another size by now"),
        (silent, f"no {BODY} of this version, or a rig without statistics of bodies"),
    )
    others = [f"{count} left out: {why}." for count, why in said if count]
    if unchecked:
        others.append(
            f"{unchecked} of an earlier version, which kept no hashes: not known whether files are the fits'."
        )
    return Cohort(prior, tuple(others))


@cache
def example_scans() -> frozenset[str]:
    """sha256 of the package's example scans."""
    files = asset_folder("example").glob("*/scan.*")
    return frozenset(hashlib.sha256(file.read_bytes()).hexdigest() for file in files)


def cohort_of_folders(folders: Sequence[Path], rig: Rig, with_example: bool = False) -> Cohort:
    """`cohort_in`; raises BadInput where no fit counts."""
    found = cohort_in(folders, rig, with_example)
    if not found.prior.women:
        raise BadInput(" ".join(("None of these fits says anything of bodies.", *found.others)))
    return found


def _fits(folders: Sequence[Path]) -> Iterator[Path]:
    for folder in folders:
        places = sorted(file.parent for file in folder.rglob(RESULT))
        if not places:
            raise BadInput(
                f"There is no fit in {folder_name(folder)}; give folders that `breastrig fit` or `batch` wrote."
            )
        yield from places


def _is_of_other_size(place: Path) -> bool:
    """Of a fit in a case: whether its scan got another size since."""
    try:
        content = (place / FIT).read_bytes()
    except FileNotFoundError:
        return False
    return is_of_other_size(place, read_document(FitDocument, content, FIT))


def _sums(place: Path, rig: Rig, result: ResultFile) -> Sums | None:
    try:
        content = read_ordinary(place / BODY, BODY_BYTES)
    except OSError:
        return None
    return parsed_contribution(content, rig, result.stance)


def _patient(place: Path, result: ResultFile) -> str:
    """The patient's code where a person has given one; else each folder is of another patient."""
    given = result.patient is not None and result.patient.given
    return f"code {result.patient.code}" if given and result.patient else f"folder {place.resolve()}"
