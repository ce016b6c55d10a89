"""Checks that lines of a plan lie on the skin of their scan: one limit, as where lines are transferred.

Each scan has a process that is kept for it a while, as a plan is saved after every line.
"""

from collections.abc import Sequence
from typing import Any

from breastrig.core.errors import NotFound
from breastrig.execution.pool import TaskQueue
from breastrig.service.failed_tasks import explained
from breastrig.storage.documents.patients import get_plan, patient_of_scan
from breastrig.storage.documents.scans import StoredScan, get_scan
from breastrig.storage.files import scan_place, upload_name
from breastrig.storage.storage import Storage
from breastrig.use.lines.lines_on_skin import SkinJob, check_lines_on_skin

WALL_S = 90.0  # half a second for the first line, of a huge scan on a busy machine many
SHOWN = 40  # characters of a note in a sentence


class SkinChecks:
    """Skin checks on all scans. May be called from any thread."""

    def __init__(self, storage: Storage, processes: TaskQueue) -> None:
        self._storage, self._processes = storage, processes

    def check(self, scan: StoredScan, shapes: Sequence[dict[str, Any]]) -> None:
        """Raises BadDrawing for a shape (mm) that lies off the scan's skin and is not on this scan yet, NotFound.

        What has been kept there stays, wherever it lies: a plan must remain one that can be saved.
        """
        plan = get_plan(self._storage, patient_of_scan(self._storage, scan.id))
        kept = [_placed(shape) for item in plan.items if item.get("scan") == scan.id for shape in shapes_of(item)]
        new = tuple(shape for shape in shapes if _placed(shape) not in kept)
        if not new:
            return
        folder = self._storage.files.folder(scan_place(scan.id))
        job = SkinJob(folder / upload_name(scan.file_type), scan.file_type, scan.facts["unit"], new)
        try:
            with explained("Checking these lines", WALL_S, "give a smaller scan", self._storage, ()):
                self._processes.result(check_lines_on_skin, (job,), WALL_S, scan.id)
        finally:
            try:
                get_scan(self._storage, scan.id)
            except NotFound:
                self._processes.pool.drop(scan.id)
                raise


def shapes_of(item: dict[str, Any]) -> list[dict[str, Any]]:
    """The part of a plan's item that is placed on the skin, as a shape: a line, or the place of a note."""
    if item["kind"] == "line":
        return [{key: item.get(key) for key in ("name", "points", "bridged")}]
    if item["kind"] == "note" and item.get("point") is not None:
        return [{"name": item["text"][:SHOWN], "points": [item["point"]]}]
    return []


def _placed(shape: dict[str, Any]) -> tuple[list[Any], list[Any]]:
    return shape["points"], shape.get("bridged") or []
