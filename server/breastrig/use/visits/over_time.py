"""What the dated scans of one patient say over time: the document, its table, plots and maps of change."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from breastrig.core.documents import csv_table, json_bytes
from breastrig.core.errors import BadInput, NotFound
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.visits.change import Change, change_between
from breastrig.report.visits.map import change_glb, change_ply, change_png
from breastrig.report.visits.plot import visits_svg
from breastrig.report.visits.series import PUBLISHED, Visit, stance_document
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of, still_visible
from breastrig.use.folder.one_body import doubts_between
from breastrig.use.reports.report import stance_of

SCHEMA = "breastrig/visits@1"
RECORD = "visits.json"
COLUMNS = (
    "stance", "visit", "less", "measure", "kind", "unit", "left", "left_low", "left_high",
    "right", "right_low", "right_high", "value", "value_low", "value_high", "not_seen", "not_known", "vague", "method",
)  # fmt: skip
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

    def with_model(self, model: Path | None) -> "VisitsJob":
        """The same with the rig that the fits were made with."""
        return replace(self, model=model)

    def dated(self, stance: str) -> list[DatedFit]:
        """Those of a stance with a date, the earliest first."""
        return sorted((f for f in self.fits if f.stance == stance and f.date), key=lambda fit: fit.date or "")

    @property
    def stances(self) -> list[str]:
        """Stances in which two scans or more have a date."""
        return [name for name in dict.fromkeys(fit.stance for fit in self.fits) if len(self.dated(name)) > 1]

    @property
    def asked(self) -> list[DatedFit]:
        """Fits without a date, of whose stance there is another scan: what is to be asked."""
        count = {name: sum(fit.stance == name for fit in self.fits) for name in {fit.stance for fit in self.fits}}
        return [fit for fit in self.fits if fit.date is None and count[fit.stance] > 1]


def visits_document(job: VisitsJob, rig: Rig | None = None) -> dict[str, Any]:
    """The document breastrig/visits@1; stances with fewer than two dates are left out.  Raises BadInput."""
    known = _Fits(job, rig)
    stances = []
    for name in job.stances:
        fits = job.dated(name)
        found = stance_document([known.visit(fit) for fit in fits])
        for change in found["changes"]:
            a, b = (fits[change[which]] for which in ("earlier", "later"))
            said = tuple(sorted((a.scan, b.scan))) in job.same
            change["doubts"] = doubts_between(known.folder(a), known.folder(b), said)
        stances.append(found)
    return {
        "schema": SCHEMA,
        "notice": LIMITS_OF_USE,
        "breastrig": __version__,
        "published": list(PUBLISHED),
        "asked": [{"scan": fit.scan, "stance": fit.stance} for fit in job.asked],
        "stances": stances,
    }


def visits_json_of(job: VisitsJob) -> bytes:
    """`visits_document` as a file."""
    return json_bytes(visits_document(job))


def visits_svg_of(job: VisitsJob, stance: str) -> bytes:
    """The plots of one stance.  Raises NotFound where fewer than two of its scans have a date."""
    document = visits_document(replace(job, fits=tuple(job.dated(stance))))
    return _svg(document, stance)


def change_map_of(job: VisitsJob, scans: tuple[str, str], kind: str, rig: Rig | None = None) -> bytes:
    """The map of two scans in one stance, "png", "glb" or "ply", on the one of the earlier visit.

    Raises NotFound for a scan without fit, BadInput where a date is missing or the stances differ.
    """
    fits = [next((fit for fit in job.fits if fit.scan == scan), None) for scan in scans]
    a, b = fits
    if a is None or b is None:
        raise NotFound("This scan has no fit that is done; fit it first.")
    if a.stance != b.stance:
        raise BadInput(f"One scan is {a.stance}, the other {b.stance}: choose two scans of one stance.")
    if a.date is None or b.date is None:
        raise BadInput("When the visits of both scans were is not known: say the day of each first.")
    earlier, later = sorted((a, b), key=lambda fit: fit.date or "")
    known = _Fits(job, rig)
    return MAPS[kind](change_between(known.visit(earlier).stance, known.visit(later).stance))


def visits_files(job: VisitsJob, rig: Rig | None = None) -> dict[str, bytes]:
    """visits.json and visits.csv, and of each stance its plots and the maps against its first visit."""
    document = visits_document(job, rig)
    files = {RECORD: json_bytes(document), "visits.csv": visits_csv(document)}
    for stance in document["stances"]:
        name, visits = stance["stance"], stance["visits"]
        files[f"visits_{name}.svg"] = _svg(document, name)
        for n, change in ((n, change) for n, change in enumerate(stance["changes"], 1) if change["map"] is not None):
            pair = tuple(visits[change[which]]["scan"] for which in ("earlier", "later"))
            for kind in MAPS:
                files[f"change_{name}_{n}.{kind}"] = change_map_of(job, pair, kind, rig)
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
    return csv_table(COLUMNS, rows)


def _svg(document: dict[str, Any], stance: str) -> bytes:
    found = next((each for each in document["stances"] if each["stance"] == stance), None)
    if found is None:
        raise NotFound(f"Fewer than two {stance} scans of this patient have a fit and the day of their visit.")
    return visits_svg(found, document["published"])


class _Fits:
    """The job's fits, each read once."""

    def __init__(self, job: VisitsJob, rig: Rig | None) -> None:
        self._rig = rig or read_rig(job.model or default_rig_path())
        self._read: dict[str, FitFolder] = {}

    def folder(self, fit: DatedFit) -> FitFolder:
        """As far as its scan is still shown."""
        if fit.scan not in self._read:
            self._read[fit.scan] = still_visible(fit_folder_of(fit.fit, self._rig), fit.cuts)
        return self._read[fit.scan]

    def visit(self, fit: DatedFit) -> Visit:
        """With its measures to be taken; its date is known."""
        folder, verdict = self.folder(fit), self.folder(fit).result.verdict
        return Visit(fit.scan, fit.date or "", fit.label, stance_of(folder), verdict.level if verdict else None)
