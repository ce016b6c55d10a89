"""The functions of this room that a service has executed in other processes.

Each imports where it is called: a server that only hands them on is spared the numerics, which take longer to import
than all else that it needs.  Their parameters are in jobs.py.
"""

from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

from breastrig.workflow.events import Event
from breastrig.workflow.jobs import (
    FitJob,
    FollowJob,
    InkJob,
    LengthsQuestion,
    LiveQuestion,
    PlanJob,
    ProposeJob,
    ReportJob,
    SnapshotJob,
    TransferJob,
    UploadJob,
)

Places = dict[str, list[float]]  # mm, in the scan's frame


def keeping(function: Callable[..., Any], *given: Any) -> Any:
    from breastrig.workflow.kept.kept_scan import keeping as task

    return task(function, *given)


def read_upload(job: UploadJob) -> dict[str, Any]:
    from breastrig.workflow.read_upload import read_upload as task

    return task(job)


def propose_on_file(job: ProposeJob) -> dict[str, Any]:
    from breastrig.workflow.propose_on_scan import propose_on_file as task

    return task(job)


def find_ink_on_file(job: InkJob) -> dict[str, Any]:
    from breastrig.workflow.find_ink_on_scan import find_ink_on_file as task

    return task(job)


def run_fit(job: FitJob) -> Generator[Event, None, None]:
    from breastrig.workflow.run_fit import run_fit as task

    return task(job)


def run_pair(first: FitJob, second: FitJob) -> Generator[tuple[int, Event], None, None]:
    from breastrig.workflow.run_pair import run_pair as task

    return task(first, second)


def transfer(job: TransferJob) -> dict[str, Any]:
    from breastrig.workflow.lines.transfer import transfer as task

    return task(job)


def plan_on_fit(job: PlanJob) -> dict[str, Any]:
    from breastrig.workflow.lines.plan_on_fit import plan_on_fit as task

    return task(job)


def live_pattern(fit: str, question: LiveQuestion | LengthsQuestion) -> dict[str, Any] | None:
    from breastrig.workflow.moving.live_pattern import live_pattern as task

    return task(fit, question)


def read_and_live_pattern(
    fit: str, folder: Path, model: Path | None, question: LiveQuestion | LengthsQuestion
) -> dict[str, Any]:
    from breastrig.workflow.moving.live_pattern import read_and_live_pattern as task

    return task(fit, folder, model, question)


def moved_landmarks(fit: str, landmarks_mm: Places) -> dict[str, Any] | None:
    from breastrig.workflow.moving.moved_landmarks import moved_landmarks as task

    return task(fit, landmarks_mm)


def follow_landmarks(fit: str, job: FollowJob, landmarks_mm: Places) -> dict[str, Any]:
    from breastrig.workflow.moving.moved_landmarks import follow_landmarks as task

    return task(fit, job, landmarks_mm)


def report_pdf_of(job: ReportJob) -> bytes:
    from breastrig.workflow.report import report_pdf_of as task

    return task(job)


def measures_json_of(job: ReportJob) -> bytes:
    from breastrig.workflow.report import measures_json_of as task

    return task(job)


def write_snapshot(job: SnapshotJob) -> None:
    from breastrig.workflow.share_snapshot import write_snapshot as task

    task(job)
