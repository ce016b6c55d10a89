"""The report without its pictures; tasks of services, imported there by name.

For tests of how a report is asked for, kept and shown; what it shows is a question of other tests.
"""

from pathlib import Path
from typing import Any

import numpy as np

from breastrig.rendering.picture import Picture, Scene
from breastrig.use.archive.objects import dicom_zip_of
from breastrig.use.reports import share_snapshot
from breastrig.use.reports.report import ReportJob, report_pages_of, report_pdf_of
from breastrig.use.reports.share_snapshot import SnapshotJob, write_snapshot


def white(_scene: Scene, _view: Any, size: tuple[int, int] = (640, 640), *_: Any, **__: Any) -> Picture:
    """A picture of that size on which nothing is."""
    return np.full((size[1], size[0], 3), 255, dtype=np.uint8)


def plain_report_pdf_of(job: ReportJob) -> bytes:
    """As `report_pdf_of`."""
    _make_plain()
    return report_pdf_of(job)


def plain_report_pages_of(job: ReportJob) -> bytes:
    """As `report_pages_of`."""
    _make_plain()
    return report_pages_of(job)


def plain_dicom_zip_of(job: ReportJob, identities: Path | None = None) -> bytes:
    """As `dicom_zip_of`."""
    _make_plain()
    return dicom_zip_of(job, identities)


def write_plain_snapshot(job: SnapshotJob) -> None:
    """As `write_snapshot`, with such a report."""
    _make_plain()
    write_snapshot(job)


def write_snapshot_with_any_report(job: SnapshotJob) -> None:
    """As `write_snapshot`, for tests that do not look at its report."""
    share_snapshot.report_pdf_of = lambda _job: b"%PDF-".ljust(500)
    write_snapshot(job)


def _make_plain() -> None:
    """The process is the task's own, so nothing is put back."""
    Scene.render = white
