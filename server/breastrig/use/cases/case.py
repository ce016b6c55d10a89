"""A case for programs: one patient's folder, as the command line and the service use it too."""

import json
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder, ScanEntry
from breastrig.cases.documents import FitDocument
from breastrig.cases.fits import FitEntry, find_fit, fits_of_scan, reason_of
from breastrig.cases.lengths import End, delete_length, put_length
from breastrig.cases.of_scans import get_cuts, get_landmarks, put_cuts, put_landmarks
from breastrig.cases.plans import get_plan, plan_versions, put_plan
from breastrig.cases.removal import Left, delete_case, delete_scan, move_scan
from breastrig.core.arrays import Array, frozen
from breastrig.core.errors import BadInput, Conflict, FitFailed, NotRemoved, unknown_name
from breastrig.core.model_choice import model_choice
from breastrig.core.one_thread import one_thread
from breastrig.core.output_files import Output, OutputSet, all_or_nothing
from breastrig.core.picks import Points
from breastrig.core.private_files import write_files
from breastrig.core.stances import AUTO, STANCES
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.patterns import drawing_with
from breastrig.drawings.plan_schema import PlanLesion, PlanLine, PlanNote, asked_of, checked_plan
from breastrig.languages.catalogue import Language
from breastrig.report.pages.printable import check_printable, checked_code
from breastrig.scan.hand_cuts import read_cuts
from breastrig.scan.images.added_lesions import TakenLesions
from breastrig.scan.images.dicom_files import sha256_of
from breastrig.scan.landmarks.marks import with_marks
from breastrig.scan.landmarks.names import known_name
from breastrig.scan.true_size import checked_mm, kept_factor
from breastrig.scan.volumes.answers import checked_answers
from breastrig.use.cases.case_work import (
    asked_fit,
    asked_prediction,
    fit_events,
    lesions_into_case,
    read_into_case,
)
from breastrig.use.cases.visits import ScanVisit, say_visit, visit_of, visits_job
from breastrig.use.fit import FitRun, to_its_end
from breastrig.use.folder.whose import asked_about
from breastrig.use.landmarks import NOTHING, Landmarks, landmarks_in_mm
from breastrig.use.lines.plan_words import texts_of
from breastrig.use.scan import Scan, ScanSource, existing, read_coloured, scan_of_stored
from breastrig.use.steps.events import Event
from breastrig.use.steps.prepare import landmark_words
from breastrig.use.steps.settings import FIRST
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import loaded
from breastrig.use.visits.over_time import RECORD as VISITS_RECORD
from breastrig.use.visits.over_time import SCHEMA as VISITS_SCHEMA
from breastrig.use.visits.over_time import visits_document, visits_files


@dataclass(frozen=True)
class CaseFit:
    """One fit of a scan of a case."""

    id: str
    scan: str
    asked_at: str  # ISO 8601, UTC
    state: str  # queued, running, done, failed, cancelled
    reason: str | None  # why it failed or was cancelled
    verdict: str | None  # good, uncalibrated, check or unusable; None before the end
    stance: str | None  # as it was fitted; None before the end
    folder: Path  # what `breastrig fit` writes is here once it is done
    predicted_from: str | None = None  # the fit of the scan, where this is another stance than the scan's


@dataclass(frozen=True)
class CaseScan:
    """One scan of a case."""

    id: str
    created_at: str  # ISO 8601, UTC
    sha256: str  # of the file's bytes
    unit: str
    triangles: int
    stance: str  # as its form shows it
    notes: tuple[str, ...]  # what reading found, one sentence each
    folder: Path
    visit: ScanVisit  # as a person has said it
    scale: float = 1.0  # from the size of its file to its true one, which all its places have


class Case:
    """One patient under a code: a folder with scans, their landmarks and fits, and the plan with its versions.

    Nothing is remembered: each call looks into the folder, which other programs may change at the same time.  Errors
    are one sentence: NotFound (a kind of BadInput) for what is gone, BadInput for what can be mended.
    """

    def __init__(self, path: str | Path) -> None:
        """Opens the case in that folder.  Raises BadInput where there is none."""
        self._folder = CaseFolder(Path(path))

    @staticmethod
    def create(path: str | Path, code: str = "") -> "Case":
        """Makes a case in a new folder, under a code of your own (never a name), or a random one.

        In a data folder, a new folder of its cases.  Raises BadInput where something is already, or nothing can be
        written.
        """
        if (Path(path) / layout.MARK).is_file():
            path = Path(path) / layout.CASES / layout.new_id()
        return Case(CaseFolder.create(Path(path), checked_code(code)).path)

    @property
    def path(self) -> Path:
        return self._folder.path

    @property
    def code(self) -> str:
        """The patient's code. Raises BadInput when the case is gone."""
        return self._folder.document().code

    def rename(self, code: str) -> None:
        """Gives the patient another code; a random one where it is empty.  Raises BadInput."""
        self._folder.rename(checked_code(code))

    @property
    def scans(self) -> tuple[CaseScan, ...]:
        """The scans, oldest first."""
        return tuple(_scan(self._folder, each) for each in self._folder.scans())

    def add_scan(
        self,
        file: str | Path,
        units: str = "auto",
        *,
        model: str = "",
        frame: str | None = None,
        segments: Mapping[int, str] | None = None,
        series: str | None = None,
        same_place: bool | str | None = None,
        again: bool = False,
    ) -> str:
        """Reads a scan's file into the case, without its name and comments; the scan's id.

        `units`, `frame`, `segments`, `series` and `same_place` are those of `read_scan`; `model` is the name of the
        packaged model to fit it with (such as male), empty for the torso.  `again` takes a file that is a scan of this
        case already.
        Raises BadScan, TooLarge or another BadInput with one sentence, and then keeps nothing.
        """
        source = existing(file)
        answers = checked_answers(frame, segments, series, same_place)
        if units != "auto" and units not in METRES_PER_UNIT:
            raise BadInput(unknown_name("unit", units, ("auto", *METRES_PER_UNIT)))
        with one_thread():
            return read_into_case(self._folder, source, sha256_of(source), units, model, answers, again)

    def add_lesions(
        self,
        scan: str,
        file: str | Path,
        *,
        frame: str | None = None,
        segments: Mapping[int, str] | None = None,
        same_place: bool | str | None = None,
    ) -> TakenLesions:
        """Reads lesions that were drawn on the scan's image into the plan: NIfTI, NRRD, DICOM SEG or RTSTRUCT.

        Lesions that the plan has are not added again; a chest wall that the file names is kept for the fits that come.
        `frame` and `segments` are those of `read_scan`; `same_place`
        says that the file lies where the image does, though it does not say so itself.
        Raises BadScan, TooLarge or another BadInput with one sentence, and then changes nothing; of BadScan
        NeedsAnswer, whose `question` has the choices.
        """
        source = existing(file)
        answers = checked_answers(frame, segments, same_place=same_place)
        with one_thread():
            return lesions_into_case(self._folder, scan, source, answers)

    def read_scan(self, scan: str) -> Scan:
        """The scan as `breastrig.read_scan` gives it: vertices (V, 3) in its own unit and frame.  Raises BadInput."""
        known = self._folder.scan(scan)
        file = self._folder.scan_folder(scan) / known.file
        return scan_of_stored(file) if known.file == layout.STORED else read_coloured(file, known.facts["unit"])

    def landmarks(self, scan: str) -> dict[str, Array]:
        """Name -> (3,) place in the scan's unit and frame, as a person has placed it.  Raises BadInput."""
        return self._places(scan, get_landmarks(self._folder, scan).points_mm)

    def _places(self, scan: str, points_mm: Points) -> dict[str, Array]:
        per_mm = 1e-3 / METRES_PER_UNIT[self._folder.scan(scan).facts["unit"]]
        return {name: frozen(per_mm * np.array(point)) for name, point in points_mm.items()}

    def marks(self, scan: str) -> dict[str, Array]:
        """Name -> (3,) place on the skin in the scan's unit and frame, of any name.  Raises BadInput."""
        return self._places(scan, get_landmarks(self._folder, scan).marks_mm)

    def put_landmarks(
        self,
        scan: str,
        landmarks: Landmarks,
        certain: Sequence[str] = (),
        marks: Mapping[str, ArrayLike] = NOTHING,
    ) -> None:
        """Replaces the scan's landmarks: name -> (3,) place in its unit and frame, or the path of a landmark file.

        Those named in `certain` are always followed.  `marks` are places on the skin under any other names, beside
        those of the file.  Of a scan with a length all are in the true size, those of a file, too, unless its `scale`
        says another (1: the scan's own file): else `delete_length`, put them, then `put_length`.
        Raises BadLandmarks or another BadInput.
        """
        scale = kept_factor(self._folder.scan_folder(scan))
        given = landmarks_in_mm(landmarks, ScanSource(self.read_scan(scan), "auto"), certain, marks, scale)
        rig = loaded(model_choice(None).of(self._folder.scan(scan).facts))
        put_landmarks(self._folder, scan, with_marks(given, landmark_words(rig)))

    def put_length(self, scan: str, start: str | ArrayLike, end: str | ArrayLike, mm: float) -> None:
        """Gives the scan its true size by a straight length that was measured on the patient, in millimetres.

        Both ends are names of the scan's landmarks or marks, or (3,) places in its unit and frame.  The scan and all
        that is kept of it is scaled about the origin of its frame; fits of another size are then `cancelled`.
        Raises BadLandmarks for a length that makes another size than a scan's errors do, Conflict while a fit of the
        scan waits or runs, or another BadInput.
        """
        facts, picks = self._folder.scan(scan).facts, get_landmarks(self._folder, scan)
        words = landmark_words(loaded(model_choice(None).of(facts)))
        per_unit = 1e3 * METRES_PER_UNIT[facts["unit"]]

        def named(end: str | ArrayLike) -> End:
            if isinstance(end, str):
                return end if end in picks.marks_mm else known_name(end, words)
            place: list[float] = (per_unit * np.asarray(end, dtype=np.float64)).tolist()
            return place

        put_length(self._folder, scan, (named(start), named(end)), checked_mm(mm))

    def delete_length(self, scan: str) -> None:
        """Gives the scan the size of its file again; fits of that size count again.  Raises as `put_length`."""
        delete_length(self._folder, scan)

    def put_visit(self, scan: str, date: str | None, label: str = "") -> None:
        """Says on which day the scan was taken (ISO 8601; None: not known), and the visit's name: before, 6 weeks.

        Raises BadInput.
        """
        say_visit(self._folder, scan, date, label)

    def visits(self) -> dict[str, Any]:
        """What the scans with a day say over time: the document breastrig/visits@1, by each scan's newest fit.

        Raises BadInput.
        """
        with one_thread():
            return visits_document(visits_job(self._folder, model_choice(None)))

    def write_visits(
        self,
        folder: str | Path,
        *,
        language: Language = "en",
        force: bool = False,
        asked_to_stop: Callable[[], None] = lambda: None,
    ) -> dict[str, Any]:
        """Writes `visits` with its table, plots and maps of change, as `breastrig visits` does; the document.

        Words in the plots are in the language.  Raises BadInput.
        """
        with one_thread():
            files = visits_files(visits_job(self._folder, model_choice(None)), language)
            output = OutputSet(Path(), tuple(files), VISITS_RECORD, VISITS_SCHEMA, varying=True)
            with all_or_nothing(Output(Path(folder), (output,), (), force, asked_to_stop)) as staging:
                write_files(files, staging)
        found: dict[str, Any] = json.loads(files[VISITS_RECORD])
        return found

    def put_cuts(self, scan: str, cuts: str | Path | Mapping[str, Any]) -> None:
        """Replaces what is cut away by hand: a file with what `GET /api/scans/ID/cuts` answers, or that itself.

        Raises BadScan or another BadInput.
        """
        put_cuts(self._folder, scan, read_cuts(cuts if isinstance(cuts, Mapping) else Path(cuts)))

    def fitting(
        self,
        scan: str,
        *,
        stance: str = "auto",
        preset: str = "default",
        drawing: str | None = FIRST,
        refine: bool = True,
        model: str | Path | None = None,
    ) -> FitRun[Event, Fit]:
        """`fit` step by step: its events (started, iterated, done), each kept in the case before it is handed on.

        The case has the fit from its first event on.  Who leaves the loop and calls `close()` cancels it.
        """
        asked = asked_fit(self._folder, scan, stance=stance, preset=preset, drawing=drawing, refine=refine)
        return self._running(scan, asked, model)

    fit = to_its_end(
        fitting,
        "fit",
        Fit,
        """Fits the model to a scan with its landmarks and cuts, and keeps the fit with its events in the case.

        Arguments are those of `breastrig.fit`; values are in the scan's unit and frame.  Raises FitFailed or BadInput;
        the case then says why.
        """,
    )

    def predict(self, fit: str, stance: str, *, model: str | Path | None = None) -> Fit:
        """The patient of a fit, by its id, in another stance; kept in the case as a fit, with its events.

        Values are in the scan's unit and frame, as those of `breastrig.predict`.  Raises BadInput, Conflict for a fit
        that is not done.
        """
        if stance not in STANCES or stance == AUTO:
            raise BadInput(unknown_name("stance", stance, tuple(each for each in STANCES if each != AUTO)))
        predicted = asked_prediction(self._folder, fit, stance)
        return self._running(find_fit(self._folder, fit).scan, predicted, model).result()

    def _running(self, scan: str, asked: FitDocument, model: str | Path | None) -> FitRun[Event, Fit]:
        rig = None if model is None else Path(model)

        def steps() -> Generator[Event, None, Fit]:
            fit = yield from fit_events(self._folder, scan, asked, rig)
            return self.load_fit(fit, rig)

        return FitRun(steps(), 0)

    def fits(self, scan: str) -> tuple[CaseFit, ...]:
        """The scan's fits, oldest first. Raises BadInput."""
        return tuple(_fit(self._folder, each) for each in fits_of_scan(self._folder, scan))

    def load_fit(self, fit: str, model: str | Path | None = None) -> Fit:
        """A fit that is done, in its scan's unit and frame; `model` as in `Fit.load`.  Raises BadInput, FitFailed."""
        found = _fit(self._folder, find_fit(self._folder, fit))
        if found.state == "failed":
            raise FitFailed(found.reason or "This fit failed; start it again.")
        if found.state != "done":
            raise Conflict(found.reason or f"This fit has no result: it is {found.state}.")
        return Fit.load(found.folder, model)

    def plan(self, version: int | None = None) -> dict[str, Any]:
        """The plan as a document breastrig/plan@1 with its version, points in mm of the scan that each item names.

        `version` is one of `plan_versions`; None: the plan in force.  Raises BadInput.
        """
        document = get_plan(self._folder, version).document
        named = {item.scan for item in document.items}
        scans = [
            {"id": one.id, "stance": one.document.facts["stance"]["proposed"], "sha256": one.document.sha256}
            for one in self._folder.scans()
            if one.id in named
        ]
        known = {"patient": self.code, "scans": scans}
        return document.model_dump(mode="json", by_alias=True, exclude={"sizes"}) | known

    @property
    def plan_etag(self) -> str:
        """The ETag of the plan in force: `put_plan` takes it as `seen`. It changes with each change, by whomever."""
        return get_plan(self._folder).etag

    @property
    def plan_versions(self) -> list[int]:
        """The numbers of the stored versions, the newest last; fifty at most."""
        return plan_versions(self._folder)

    def put_plan(
        self, document: Mapping[str, Any], seen: str | None = None, *, scan: str = "", same_patient: bool = False
    ) -> int:
        """Replaces the plan by a document breastrig/plan@1 or breastrig/drawing@1, in mm; its new version.

        `seen` is the `plan_etag` that was read before: another program may have changed the plan since, which raises
        Conflict (a kind of BadInput).  `scan` is that of items that name none.  A plan that names another
        patient's code and scans is refused unless `same_patient`.  Raises BadDrawing or another BadInput.
        """
        plan = checked_plan(dict(document))
        digests = [one.document.sha256 for one in self._folder.scans()]
        asked_about(plan.model_dump(mode="json"), digests, [self.code], same_patient)
        items = [item if item.scan else item.model_copy(update={"scan": scan}) for item in plan.items]
        unnamed = next((item.id for item in items if not item.scan), None)
        if unnamed is not None:
            raise BadInput(f'The item "{unnamed}" does not say on which scan it was made; say which with scan.')
        check_printable(texts_of(items))
        for item in items:
            if not isinstance(item, PlanLine | PlanNote | PlanLesion):
                drawing_with(loaded(None), *asked_of(item))
        return put_plan(self._folder, items, seen).document.version

    def undo(self, version: int, seen: str | None = None) -> int:
        """Puts an earlier version of the plan in force, as a new one; its number.  Raises BadInput."""
        earlier = get_plan(self._folder, version).document
        return put_plan(self._folder, earlier.items, seen).document.version

    def move_scan(self, scan: str, to: "Case", *, again: bool = False) -> None:
        """The scan is of the other case from then on, with its fits and what was planned on it.

        A case goes with its last scan.  Raises BadInput, also while a fit of the scan runs.
        """
        move_scan(self._folder, scan, to._folder, again)

    def delete_scan(self, scan: str) -> None:
        """Deletes the scan for good, with all that was made of it; the case with its last scan.

        Raises NotRemoved when it is deleted, and files of it are left.
        """
        _all_removed(delete_scan(self._folder, scan))

    def delete(self) -> None:
        """Deletes the case for good.  Raises NotRemoved when it is deleted, and files of it are left."""
        _all_removed(delete_case(self._folder))

    def __repr__(self) -> str:
        return f"<Case {self.code}: {len(self._folder.scan_ids())} scans>"

    def cuts(self, scan: str) -> tuple[dict[str, Any], ...]:
        """The scan's cuts by hand, oldest first. Raises BadInput."""
        return get_cuts(self._folder, scan)


def _scan(folder: CaseFolder, entry: ScanEntry) -> CaseScan:
    facts = entry.document.facts
    return CaseScan(
        id=entry.id,
        created_at=entry.document.created_at,
        sha256=entry.document.sha256,
        unit=facts["unit"],
        triangles=facts.get("triangles", 0),
        stance=facts["stance"]["proposed"],
        notes=tuple(facts.get("notes", ())),
        folder=folder.scan_folder(entry.id),
        visit=visit_of(folder, entry.id),
        scale=facts.get("scale", {}).get("factor", 1.0),
    )


def _fit(folder: CaseFolder, entry: FitEntry) -> CaseFit:
    place, last = folder.path / layout.fit_part(entry.scan, entry.id), entry.last or {}
    result = last.get("result", {})
    return CaseFit(
        id=entry.id,
        scan=entry.scan,
        asked_at=entry.document.asked_at,
        state=entry.state,
        reason=reason_of(place, entry.document, last),
        verdict=(result.get("verdict") or {}).get("level"),
        stance=result.get("stance"),
        folder=place,
        predicted_from=entry.document.predicted_from,
    )


def _all_removed(left: Sequence[Left]) -> None:
    if left:
        raise NotRemoved(len(left))
