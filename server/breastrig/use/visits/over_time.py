"""What the dated scans of one patient say over time: the document, its table, plots and maps of change."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from breastrig.core.documents import csv_table, json_bytes
from breastrig.core.errors import BadInput, NotFound
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.languages.catalogue import ENGLISH
from breastrig.report.table import COLUMNS
from breastrig.report.visits.change import Change, change_between
from breastrig.report.visits.map import change_glb, change_ply, change_png
from breastrig.report.visits.plot import visits_svg
from breastrig.report.visits.series import PUBLISHED, Visit, stance_document
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of, still_visible
from breastrig.use.folder.one_body import doubts_between
from breastrig.use.reports.report import stance_of

SCHEMA = "breastrig/visits@1"
RECORD = "visits.json"
MAPS: dict[str, Callable[[Change], bytes]] = {"png": change_png, "glb": change_glb, "ply": change_ply}


@dataclass(frozen=True)
class DatedFit:
    """The fit of one scan, with the day of its visit as a person has said it."""

    scan: str
    fit: Path
    stance: str
    date: str | None  # ISO 8601, a day
    label: str = ""
    cuts: tuple[dict[str, Any], ...] = ()


@dataclass(frozen=True)
class VisitsJob:
    """All scans of one patient that have a fit."""

    fits: tuple[DatedFit, ...]
    same: frozenset[tuple[str, str]] = frozenset()  # pairs of scans that a person has said to be of one patient
    model: Path | None = None  # None: the torso of the package

    def dated(self, stance: str) -> tuple[DatedFit, ...]:
        """Those of a stance with a date, the earliest first."""
        return tuple(sorted((f for f in self.fits if f.stance == stance and f.date), key=lambda fit: fit.date or ""))


def visits_document(job: VisitsJob) -> dict[str, Any]:
    """The document breastrig/visits@1; stances with fewer than two dates are left out.  Raises BadInput."""
    stances, count = [], Counter(fit.stance for fit in job.fits)
    for fits in filter(lambda fits: len(fits) > 1, map(job.dated, count)):
        folders, visits = zip(*_read(job, fits), strict=True)
        found = stance_document(visits)
        for change in found["changes"]:
            a, b = change["earlier"], change["later"]
            said = tuple(sorted((fits[a].scan, fits[b].scan))) in job.same
            change["doubts"] = doubts_between(folders[a], folders[b], said)
        stances.append(found)
    asked = [{"scan": f.scan, "stance": f.stance} for f in job.fits if f.date is None and count[f.stance] > 1]
    about = {"schema": SCHEMA, "notice": LIMITS_OF_USE, "breastrig": __version__, "published": list(PUBLISHED)}
    return about | {"asked": asked, "stances": stances}


def visits_json_of(job: VisitsJob) -> bytes:
    """`visits_document` as a file."""
    return json_bytes(visits_document(job))


def visits_svg_of(job: VisitsJob, stance: str, language: str) -> bytes:
    """The plots of one stance.  Raises NotFound where fewer than two of its scans have a date."""
    found = visits_document(replace(job, fits=job.dated(stance)))["stances"]
    if not found:
        raise NotFound(f"Fewer than two {stance} scans of this patient have a fit and the day of their visit.")
    return visits_svg(found[0], PUBLISHED, language)


def change_map_of(job: VisitsJob, scans: tuple[str, str], kind: str) -> bytes:
    """The map of two scans in one stance, "png", "glb" or "ply", on the one of the earlier visit.

    Raises NotFound for a scan without fit, BadInput where a date is missing or the stances differ.
    """
    fits = [fit for scan in scans for fit in job.fits if fit.scan == scan]
    if len(fits) < len(scans):
        raise NotFound("This scan has no fit that is done; fit it first.")
    a, b = fits
    if a.stance != b.stance:
        raise BadInput(f"One scan is {a.stance}, the other {b.stance}: choose two scans of one stance.")
    if a.date is None or b.date is None:
        raise BadInput("When the visits of both scans were is not known: say the day of each first.")
    return MAPS[kind](_change(replace(job, fits=(a, b))))


def _change(job: VisitsJob) -> Change:
    """Between the job's two fits, which are dated and in one stance."""
    (_, earlier), (_, later) = _read(job, job.dated(job.fits[0].stance))
    return change_between(earlier.stance, later.stance)


def visits_files(job: VisitsJob, language: str = ENGLISH) -> dict[str, bytes]:
    """visits.json and visits.csv, and of each stance its plots in the language, and its maps of change."""
    document = visits_document(job)
    files = {RECORD: json_bytes(document), "visits.csv": visits_csv(document)}
    for stance in document["stances"]:
        name, fits = stance["stance"], job.dated(stance["stance"])
        files[f"visits_{name}.svg"] = visits_svg(stance, PUBLISHED, language)
        for n, change in enumerate(stance["changes"], 1):
            if change["map"] is not None:
                found = _change(replace(job, fits=(fits[change["earlier"]], fits[change["later"]])))
                files |= {f"change_{name}_{n}.{kind}": made(found) for kind, made in MAPS.items()}
    return files


def visits_csv(document: dict[str, Any]) -> bytes:
    """A row a measure of each visit, then of each change."""
    rows = []
    for stance in document["stances"]:
        named = [f"{visit['date']} {visit['label']}".rstrip() for visit in stance["visits"]]
        own = {"stance": stance["stance"], "less": ""}
        rows += [own | row | {"visit": named[row["visit"]]} for row in stance["measures"]]
        for change in stance["changes"]:
            between = {"visit": named[change["later"]], "less": named[change["earlier"]]}
            rows += [own | row | between for row in change["measures"]]
    return csv_table(("visit", "less", *COLUMNS), rows)


def _read(job: VisitsJob, fits: Sequence[DatedFit]) -> Iterator[tuple[FitFolder, Visit]]:
    """Each fit as far as its scan is still shown, and its visit; its date is known."""
    rig = read_rig(job.model or default_rig_path())
    for fit in fits:
        folder = still_visible(fit_folder_of(fit.fit, rig), fit.cuts)
        verdict = folder.result.verdict
        yield folder, Visit(fit.scan, fit.date or "", fit.label, stance_of(folder), verdict.level if verdict else None)
