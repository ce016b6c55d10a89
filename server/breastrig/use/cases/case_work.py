"""A case at work: a scan read into it, a fit run in it.  Knows neither processes nor the index."""

import dataclasses
import json
from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder, sync_file, utc_now
from breastrig.cases.documents import FitDocument, ScanDocument
from breastrig.cases.fits import CANCELLED, OTHER_SIZE, Claim, added, events_after, find_fit, fit_ids, get_fit
from breastrig.cases.of_scans import get_cuts, get_landmarks
from breastrig.cases.plans import add_lesions, put_items_of_scan
from breastrig.cases.writing import replace
from breastrig.core.errors import BadInput, BadScan, BreastRigError, Conflict
from breastrig.core.model_choice import FACT, model_choice
from breastrig.core.stances import Stance
from breastrig.core.units import UNIT_CHOICES
from breastrig.drawings.plan_schema import PlanLesion
from breastrig.files.result import RESULT
from breastrig.scan.images.added_lesions import NO_IMAGE, LesionsRead, TakenLesions
from breastrig.scan.limits import TRIANGLES
from breastrig.scan.stored_scan import read_stored, write_stored
from breastrig.scan.true_size import kept_factor
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers
from breastrig.use.fit import run_fit
from breastrig.use.predict import PredictionJob, run_prediction
from breastrig.use.read_upload import LesionsJob, UploadJob, read_lesions, read_upload
from breastrig.use.steps.events import Event, Failed, event_json
from breastrig.use.steps.settings import EarlierFit, FitJob

FIT_AGAIN = "Fits of this image that were made before do not know its chest wall; fit it again."
BROKE = "The fit broke for a reason inside BreastRig; start the fit again."


def read_into_case(
    case: CaseFolder,
    file: Path,
    sha256: str,
    units: str = "auto",
    model: str = "",
    answers: VolumeAnswers = NOTHING_SAID,
    again: bool = False,
) -> str:
    """Reads a scan's file and keeps what was read of it, without names and comments; the scan's id.

    `model` is the name of the packaged model to fit it with, empty for the first.  What a label map shows inside
    becomes items of the plan.  Raises BadScan, TooLarge, NeedsYes where the case has that file already and nobody said
    `again`; then nothing is kept.
    """
    assert units in UNIT_CHOICES
    own = model_choice(None)
    chosen = {FACT: model} if model in own.others else {}
    with case.incoming() as made:
        names = layout.STORED, layout.MESH, layout.THUMBNAIL, layout.VOLUME
        kept, mesh, small, volume = (made / name for name in names)
        facts = read_upload(UploadJob(file, units, kept, mesh, small, volume, TRIANGLES, own.of(chosen), answers))
        lesions: list[dict[str, Any]] = facts.pop("lesions", [])
        facts.pop("labels", None)  # the file's own words are nowhere kept
        scan_id = case.add_scan(
            made, ScanDocument(created_at=utc_now(), sha256=sha256, facts=facts | chosen), again=again
        )
    if lesions:
        items = [PlanLesion.model_validate({"id": layout.new_id(), "scan": scan_id, **each}) for each in lesions]
        put_items_of_scan(case, scan_id, "lesion", items)
    return scan_id


def volume_of(case: CaseFolder, scan_id: str) -> Path:
    """The image of the scan.  Raises NotFound, BadScan for a scan that was made of none."""
    case.check_scan(scan_id)
    file = case.scan_folder(scan_id) / layout.VOLUME
    if not file.is_file():
        raise BadScan(NO_IMAGE)
    return file


def lesions_into_case(case: CaseFolder, scan_id: str, file: Path, answers: VolumeAnswers) -> TakenLesions:
    """Reads lesions of another file than the scan's, which lie in its image, into the plan.

    Nothing but a chest wall is kept of the file.  Raises BadScan, TooLarge, NotFound, Conflict.
    """
    return take_lesions(case, scan_id, read_lesions(LesionsJob(file, volume_of(case, scan_id), answers)))


def take_lesions(case: CaseFolder, scan_id: str, read: LesionsRead) -> TakenLesions:
    """Lesions that were read into the plan, and a chest wall into the kept scan, for the fits that come.

    Raises NotFound, Conflict, OSError.
    """
    notes = read.notes
    if read.wall is not None:
        with case.incoming() as made, case.writing():
            file = case.scan_folder(scan_id) / case.scan(scan_id).file
            wall = 1e-3 * read.wall[0], read.wall[1]
            write_stored(dataclasses.replace(read_stored(file, for_display=False), wall=wall), made / file.name)
            sync_file(made / file.name)
            replace(made / file.name, file)
        notes += (FIT_AGAIN,) if fit_ids(case, scan_id) else ()
    return add_lesions(case, scan_id, read.lesions, read.segments, notes)


def asked_fit(case: CaseFolder, scan_id: str, **asked: Any) -> FitDocument:
    """A fit of the scan to be run, with its landmarks and cuts as they are now.  Raises NotFound."""
    picks = get_landmarks(case, scan_id)
    return FitDocument(
        asked_at=utc_now(),
        landmarks_mm=picks.points_mm,
        certain=list(picks.certain),
        confidence=picks.confidence,
        marks_mm=picks.marks_mm,
        cuts=list(get_cuts(case, scan_id)),
        scale=kept_factor(case.scan_folder(scan_id)),
        **asked,
    )


def asked_prediction(case: CaseFolder, fit_id: str, stance: str) -> FitDocument:
    """The patient of a fit in another stance, to be run as a fit like any other.

    Raises NotFound, Conflict when the fit is not done, BadInput when nothing can be predicted from it.
    """
    fit = find_fit(case, fit_id)
    if fit.document.predicted_from is not None:
        raise BadInput("This fit is itself predicted; predict from the fit of a scan.")
    if fit.state != "done" or fit.last is None:
        raise Conflict(f"This fit is {fit.state}; a stance is predicted from a fit that is done.")
    if fit.last["result"]["stance"] == stance:
        raise BadInput(f"The scan is {stance} already; ask for another stance.")
    asked = {"asked_at": utc_now(), "stance": stance, "predicted_from": fit_id}
    return fit.document.model_copy(update=asked | dict.fromkeys(("start_from", "key_sha256", "request_sha256")))


Runner = Callable[[FitJob], Generator[Event, None, None]]
Predictor = Callable[[PredictionJob], Generator[Event, None, None]]


@dataclass(frozen=True)
class Runners:
    """The functions that run a fit and a prediction."""

    fit: Runner = run_fit
    prediction: Predictor = run_prediction


def fit_events(
    case: CaseFolder, scan_id: str, asked: FitDocument, model: Path | None = None
) -> Generator[Event, None, str]:
    """Keeps a fit in the case and runs it: its events, each stored before it is handed on; returns the fit's id.

    `model` is another rig than the scan's.  Nobody else can take the fit up.  Who leaves the generator cancels it.
    Raises NotFound, the fit's own BreastRigError after it is stored as its end.
    """
    with added(case, scan_id, asked) as claim, _ending(claim), case.incoming() as made:
        yield from stored_events(claim, made, model or model_choice(None).of(case.scan(scan_id).facts), Runners())
    return claim.fit_id


def stored_events(claim: Claim, made: Path, model: Path | None, run: Runners) -> Generator[Event, None, None]:
    """Runs the fit of the claim, or the prediction: its events, each stored before it is handed on.

    Files are made in the folder `made`, and are in the fit's before the event that says so.  Ends early when the fit
    was cancelled.
    """
    job = job_of(claim.case, claim.scan_id, claim.document, made, model)
    with closing(run.prediction(job) if isinstance(job, PredictionJob) else run.fit(job)) as events:
        for event in events:
            if event.kind == "done":
                put_files(made, claim.folder)
            if not claim.append(event_json(event)):
                return
            yield event


@contextmanager
def _ending(claim: Claim) -> Iterator[None]:
    """Stores the end of the fit, whatever ends it, as its last event."""
    try:
        yield
    except BreastRigError as error:
        claim.end(event_json(Failed(reason=str(error))))
        raise
    except (GeneratorExit, KeyboardInterrupt):
        claim.end(CANCELLED)
        raise
    except Exception:
        with suppress(OSError, BreastRigError):
            claim.end(event_json(Failed(reason=BROKE)))
        raise


def put_files(made: Path, folder: Path) -> None:
    """The fit's files in their place, result.json last; the log is there already."""
    names = {each.name for each in made.iterdir()} - {layout.LOG, RESULT}
    for name in (*sorted(names), *([RESULT] if (made / RESULT).exists() else [])):
        sync_file(made / name)
        replace(made / name, folder / name)


def job_of(case: CaseFolder, scan_id: str, asked: FitDocument, out: Path, model: Path | None) -> FitJob | PredictionJob:
    """The job of a fit or prediction as it was asked for, with its scan at hand.  Raises NotFound, Conflict.

    The unit is the one that was decided, and shown, at the upload.
    """
    scan = case.scan(scan_id)
    facts = scan.facts
    if asked.scale != kept_factor(case.scan_folder(scan_id)):
        raise Conflict(OTHER_SIZE)
    if asked.predicted_from is not None:
        source = case.path / layout.fit_part(scan_id, asked.predicted_from)
        return PredictionJob(source, out, cast(Stance, asked.stance), asked.drawing, model)
    return FitJob(
        scan=case.scan_folder(scan_id) / scan.file,
        out=out,
        landmarks_mm=asked.landmarks_mm,
        certain=tuple(asked.certain),
        landmark_confidence=asked.confidence,
        marks_mm=asked.marks_mm,
        units=facts["unit"],
        file_type=scan.file.partition(".")[2],
        stance=asked.stance,
        preset=asked.preset,
        drawing=asked.drawing,
        model=model,
        refine=asked.refine,
        orientation=None if asked.cuts else facts.get("orientation"),  # that is of the whole scan
        cuts=tuple(asked.cuts),
        earlier=None if asked.start_from is None else _earlier(case, scan_id, asked.start_from),
    )


def _earlier(case: CaseFolder, scan_id: str, fit_id: str) -> EarlierFit:
    """A fit that is done, as its last iteration stands, to go on from.  Raises NotFound, Conflict."""
    get_fit(case, scan_id, fit_id)
    lines = [json.loads(line) for _, line in events_after(case.path / layout.fit_part(scan_id, fit_id))]
    first = next((event for event in lines if event["kind"] == "started"), None)
    last = next((event for event in reversed(lines) if event["kind"] == "iterated"), None)
    if first is None or last is None:
        raise Conflict("The fit to go on from has not come to a first iteration; start the fit without it.")
    return EarlierFit(first["stance"], last["nodes"], first["model_sha256"])
