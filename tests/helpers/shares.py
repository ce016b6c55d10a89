"""Share links whose time is over without waiting for it."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

from breastrig.cases import layout
from breastrig.cases.documents import content_of
from breastrig.cases.links import get_link
from breastrig.cases.writing import put
from breastrig.index.questions import fit_of_link
from breastrig.service.service import Service
from breastrig.storage.storage import iso_utc


def shown_files(service: Service, share_id: str) -> Path:
    """The folder of what the link shows."""
    where = service.storage.index.asked(fit_of_link, share_id)
    assert where is not None
    case, scan_id, fit_id = service.storage.case(where[0]), where[1], where[2]
    shown = get_link(case, scan_id, fit_id, share_id).shown
    return case.path / layout.link_part(scan_id, fit_id, share_id) / f"{layout.SHOWN}{shown}"


def expire(service: Service, share_id: str) -> None:
    """Sets the share's end to a second ago."""
    past = iso_utc(datetime.now(UTC) - timedelta(seconds=1))
    where = service.storage.index.asked(fit_of_link, share_id)
    assert where is not None
    case, scan_id, fit_id = service.storage.case(where[0]), where[1], where[2]
    with case.writing():
        link = get_link(case, scan_id, fit_id, share_id).model_copy(update={"expires_at": past})
        put(case.path, f"{layout.link_part(scan_id, fit_id, share_id)}/{layout.LINK}", content_of(link))
    service.storage.index.refresh(case.id)
