"""Results of searches on a scan: landmarks that a model proposed, and lines of ink on the skin."""

from collections.abc import Mapping
from typing import Any

from breastrig.cases import of_scans
from breastrig.cases.documents import InkDocument
from breastrig.cases.of_scans import NOT_YET as NOT_YET
from breastrig.core.errors import NotFound
from breastrig.storage.storage import Storage


def get_proposals(storage: Storage, scan_id: str, model_sha256: str) -> dict[str, Any] | None:
    """The proposals of that model; None where there are none yet."""
    try:
        return of_scans.get_proposals(storage.case_of_scan(scan_id), scan_id, model_sha256)
    except NotFound:
        return None


def put_proposals(storage: Storage, scan_id: str, model_sha256: str, landmarks: dict[str, Any]) -> None:
    """Keeps the proposals, in place of an older model's.  Raises NotFound when the scan is gone."""
    of_scans.put_proposals(storage.case_of_scan(scan_id), scan_id, model_sha256, landmarks)


def get_ink(storage: Storage, scan_id: str) -> dict[str, Any] | None:
    """The found drawing, with dropped shapes marked; None before the first search."""
    try:
        found = of_scans.get_ink(storage.case_of_scan(scan_id), scan_id)
    except NotFound:
        return None
    return None if found is None else _drawing(found)


def put_ink(storage: Storage, scan_id: str, drawing: dict[str, Any]) -> None:
    """Stores the found lines. Raises NotFound when the scan is gone."""
    of_scans.put_ink(storage.case_of_scan(scan_id), scan_id, drawing)


def drop_ink(storage: Storage, scan_id: str, dropped: Mapping[str, bool]) -> dict[str, Any]:
    """Keeps of the named shapes whether they are dropped, others stay as they are; answers as `get_ink`.

    Raises NotFound when the scan is gone, Conflict before its ink was found, BadDrawing for a name that it has not.
    """
    return _drawing(of_scans.drop_ink(storage.case_of_scan(scan_id), scan_id, dict(dropped)))


def _drawing(found: InkDocument) -> dict[str, Any]:
    document = found.model_dump(mode="json", by_alias=True)
    dropped, _ = document.pop("dropped"), document.pop("scale")
    shapes = [shape | {"dropped": True} if shape["name"] in dropped else shape for shape in document["shapes"]]
    return document | {"shapes": shapes}
