"""The documents on one scan by people and searches: landmarks, cuts, ink, answers, proposals; one document each.

Each is replaced as a whole; where the ETag of the one that was seen is given, only that one.
"""

from collections.abc import Callable, Collection
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import (
    NOTHING,
    AnswersDocument,
    CutsDocument,
    InkDocument,
    ProposalsDocument,
    content_of,
    etag_of,
)
from breastrig.cases.layout import scan_part
from breastrig.cases.writing import Changed, put, sync_folder
from breastrig.core.errors import BadDrawing, Conflict
from breastrig.core.picks import Picks
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.hand_cuts import cut_in
from breastrig.scan.landmarks.landmark_files import (
    certain_landmarks,
    landmark_confidences,
    landmark_file,
    landmark_scale,
    read_landmarks,
    read_marks,
)
from breastrig.scan.true_size import kept_factor

NOT_YET = "The ink of this scan has not been looked for yet; ask for it first."

Read = TypeVar("Read", bound=BaseModel)


def get_landmarks(case: CaseFolder, scan_id: str) -> Picks:
    """In mm, the scan's frame and size; empty when nobody has placed any.

    Raises NotFound, BadLandmarks for a damaged file.
    """
    case.check_scan(scan_id)
    content = case.content(f"{scan_part(scan_id)}/{layout.LANDMARKS}")
    if content is None:
        return Picks({})
    points, unit = read_landmarks(content)
    per_unit = 1e3 * METRES_PER_UNIT[unit or case.scan(scan_id).facts["unit"]]
    places, marks = (
        {name: (per_unit * point).tolist() for name, point in each.items()} for each in (points, read_marks(content)[0])
    )
    picks = Picks(places, certain_landmarks(content), landmark_confidences(content), marks)
    return picks.times(_factor(case, scan_id) / (landmark_scale(content) or 1.0))


def put_landmarks(
    case: CaseFolder, scan_id: str, picks: Picks, seen: str | None = None, digest: Callable[[], str] | None = None
) -> str:
    """Replaces them; the new ETag.  `seen` is the ETag of those that are there, or what `digest` gives.

    Without any there is no file.  Raises NotFound, Changed.
    """
    content = landmark_document(picks, _factor(case, scan_id)) if picks.points_mm or picks.marks_mm else None
    return _put(case, scan_id, layout.LANDMARKS, content, seen, digest)


def landmark_document(picks: Picks, scale: float = 1.0) -> bytes:
    """breastrig/landmarks@1 in mm, of a scan that is so many times as large as its file says."""
    places, marks = (
        {name: np.array(point) for name, point in each.items()} for each in (picks.points_mm, picks.marks_mm)
    )
    return landmark_file(places, "json", "mm", picks.certain, picks.confidence, marks, scale)


def _factor(case: CaseFolder, scan_id: str) -> float:
    return kept_factor(case.scan_folder(scan_id))


def get_cuts(case: CaseFolder, scan_id: str) -> tuple[dict[str, Any], ...]:
    """The scan's cuts, oldest first; empty where nothing was cut. Raises NotFound."""
    found = _get(case, scan_id, layout.CUTS, CutsDocument)
    if found is None:
        return ()
    factor = _factor(case, scan_id) / found.scale
    return tuple(found.cuts if factor == 1.0 else [cut_in(cut, factor) for cut in found.cuts])


def put_cuts(
    case: CaseFolder,
    scan_id: str,
    cuts: tuple[dict[str, Any], ...],
    seen: str | None = None,
    digest: Callable[[], str] | None = None,
) -> str:
    """Replaces the scan's cuts, as `put_landmarks` does landmarks."""
    document = CutsDocument(cuts=list(cuts), scale=_factor(case, scan_id))
    return _put(case, scan_id, layout.CUTS, content_of(document), seen, digest)


def get_ink(case: CaseFolder, scan_id: str) -> InkDocument | None:
    """The lines that were found; None before the first search in the scan's size. Raises NotFound."""
    found = _get(case, scan_id, layout.INK, InkDocument)
    return found if found is not None and found.scale == _factor(case, scan_id) else None


def put_ink(case: CaseFolder, scan_id: str, drawing: dict[str, Any]) -> None:
    """Keeps what was found; what was dropped stays dropped.  Raises NotFound."""
    with case.writing():
        before = _get(case, scan_id, layout.INK, InkDocument)
        known = {"dropped": [] if before is None else before.dropped, "scale": _factor(case, scan_id)}
        found = InkDocument.model_validate(drawing | known)
        put(case.path, f"{scan_part(scan_id)}/{layout.INK}", content_of(found))


def drop_ink(case: CaseFolder, scan_id: str, dropped: dict[str, bool]) -> InkDocument:
    """Keeps of the named shapes whether they are none of the plan; others stay as they are.

    Raises NotFound, Conflict before its ink was found, BadDrawing for a name that it has not.
    """
    with case.writing():
        found = get_ink(case, scan_id)
        if found is None:
            raise Conflict(NOT_YET)
        names = [shape["name"] for shape in found.shapes]
        strange = next((name for name in dropped if name not in names), None)
        if strange is not None:
            raise BadDrawing(f'No line called "{strange}" was found on this scan; name one of those that were.')
        now = [name for name in names if dropped.get(name, name in found.dropped)]
        changed = found.model_copy(update={"dropped": now})
        put(case.path, f"{scan_part(scan_id)}/{layout.INK}", content_of(changed))
    return changed


def get_answers(case: CaseFolder, scan_id: str) -> AnswersDocument:
    """A person's answers about the scan. Raises NotFound."""
    return _get(case, scan_id, layout.ANSWERS, AnswersDocument) or AnswersDocument()


def say_model(case: CaseFolder, scan_id: str, model: str) -> None:
    """Stores the statement that the model of this name is the right one for the scan. Raises NotFound."""
    with case.writing():
        _put_answers(case, scan_id, model=model)


def put_visit(case: CaseFolder, scan_id: str, day: str | None, label: str) -> None:
    """Stores the day (ISO 8601) and the label of the scan's visit. Raises NotFound."""
    with case.writing():
        _put_answers(case, scan_id, visit_date=day, visit=label or None)


def said_same(case: CaseFolder, scan_id: str) -> set[str]:
    """Scans that a person has stated to be of the same patient as this one. Raises NotFound."""
    named = set(get_answers(case, scan_id).same_as)
    others = case.scan_ids() - {scan_id}
    return {other for other in others if other in named or scan_id in get_answers(case, other).same_as}


def say_same(case: CaseFolder, scan_id: str, others: Collection[str]) -> None:
    """Stores the statement that these scans are of the same patient too; under `writing`."""
    missing = set(others) - said_same(case, scan_id) - {scan_id}
    if missing:
        _name_same(case, scan_id, {*get_answers(case, scan_id).same_as, *missing})


def forget_same(case: CaseFolder, scan_id: str) -> None:
    """Drops all statements that this scan, which may be gone, and others are of one patient; under `writing`."""
    for other in case.scan_ids():
        named = set(get_answers(case, other).same_as)
        kept = set() if other == scan_id else named - {scan_id}
        if kept != named:
            _name_same(case, other, kept)


def _name_same(case: CaseFolder, scan_id: str, scans: Collection[str]) -> None:
    _put_answers(case, scan_id, same_as=sorted(scans))


def _put_answers(case: CaseFolder, scan_id: str, **said: Any) -> None:
    answers = get_answers(case, scan_id).model_copy(update=said)
    put(case.path, f"{scan_part(scan_id)}/{layout.ANSWERS}", content_of(answers))


def get_proposals(case: CaseFolder, scan_id: str, key: str) -> dict[str, Any] | None:
    """The landmarks that were proposed under that key; None when none were.  Raises NotFound."""
    found = _get(case, scan_id, layout.PROPOSALS, ProposalsDocument)
    return None if found is None or found.key != key else found.landmarks


def put_proposals(case: CaseFolder, scan_id: str, key: str, landmarks: dict[str, Any]) -> None:
    """Replaces the proposals. Raises NotFound."""
    _put(case, scan_id, layout.PROPOSALS, content_of(ProposalsDocument(key=key, landmarks=landmarks)), None)


def etag_of_scan(case: CaseFolder, scan_id: str, name: str) -> str:
    """The ETag of one of the scan's documents; NOTHING where there is none.  Raises NotFound."""
    case.check_scan(scan_id)
    content = case.content(f"{scan_part(scan_id)}/{name}")
    return NOTHING if content is None else etag_of(content)


def _get(case: CaseFolder, scan_id: str, name: str, kind: type[Read]) -> Read | None:
    case.check_scan(scan_id)
    return case.read(f"{scan_part(scan_id)}/{name}", kind)


def _put(
    case: CaseFolder,
    scan_id: str,
    name: str,
    content: bytes | None,
    seen: str | None,
    digest: Callable[[], str] | None = None,
) -> str:
    with case.writing():
        etag = etag_of_scan(case, scan_id, name)
        etag = digest() if digest is not None else etag
        if seen is not None and seen != etag:
            raise Changed(etag)
        if content is not None:
            put(case.path, f"{scan_part(scan_id)}/{name}", content)
            return etag_of(content)
        (case.scan_folder(scan_id) / name).unlink(missing_ok=True)
        sync_folder(case.scan_folder(scan_id))
    return NOTHING
