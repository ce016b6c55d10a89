"""Pictures that cost little, for tests of files that hold pictures: what is shown is a question of other tests."""

from typing import Any

import pytest

from breastrig.rendering.picture import Picture, Scene
from breastrig.service import reports, share_snapshots
from helpers.plain_report import (
    plain_dicom_zip_of,
    plain_report_pages_of,
    plain_report_pdf_of,
    white,
    write_plain_snapshot,
    write_snapshot_with_any_report,
)

COARSER = 4


def blank_pictures(patch: pytest.MonkeyPatch) -> None:
    """From now on every picture that this process makes is white, of the size that is asked for."""
    patch.setattr(Scene, "render", white)


def blank_pictures_in_reports(patch: pytest.MonkeyPatch) -> None:
    """From now on every report that services of this process have made, of links too, has such pictures."""
    patch.setitem(reports.MAKERS, "report.pdf", plain_report_pdf_of)
    patch.setitem(reports.MAKERS, "pages.zip", plain_report_pages_of)
    patch.setitem(reports.MAKERS, "dicom.zip", plain_dicom_zip_of)
    patch.setattr(reports, "dicom_zip_of", plain_dicom_zip_of)
    patch.setattr(share_snapshots, "write_snapshot", write_plain_snapshot)


def any_reports_of_links(patch: pytest.MonkeyPatch) -> None:
    """From now on links that services of this process make have a report on which nothing is."""
    patch.setattr(share_snapshots, "write_snapshot", write_snapshot_with_any_report)


def coarse_pictures(patch: pytest.MonkeyPatch) -> None:
    """From now on every picture that this process makes is drawn with a sixteenth of the rays, and as large as ever."""
    render = Scene.render

    def coarse(scene: Scene, view: Any, size: tuple[int, int] = (640, 640), *more: Any, **named: Any) -> Picture:
        width, height = size
        drawn = render(scene, view, (-(-width // COARSER), -(-height // COARSER)), *more, **named)
        return drawn.repeat(COARSER, axis=0).repeat(COARSER, axis=1)[:height, :width]

    patch.setattr(Scene, "render", coarse)
