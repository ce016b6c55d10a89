"""The plan of a case, and its earlier versions.

It is replaced only by who has seen the one that is there, which its ETag proves: the SHA-256 of the file, as numbers
are repeated by hand edits and restored copies.  The version before stays as a hard link, the last fifty of them.
An item whose scan is not here is not shown: so one rename decides about a scan and all that was planned on it.
"""

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from breastrig.cases.case_folder import CaseFolder, utc_now
from breastrig.cases.documents import NOTHING, PlanDocument, content_of, etag_of, read_document
from breastrig.cases.layout import PLAN, PLANS, new_id
from breastrig.cases.writing import PART, Changed, put, replace
from breastrig.core.errors import Conflict, NotFound
from breastrig.drawings.plan_schema import ITEMS, PlanItem, PlanLesion, PlanLine, PlanNote
from breastrig.scan.images.added_lesions import TakenLesions, taken
from breastrig.scan.piece import BallInside, TakenSegment
from breastrig.scan.true_size import kept_factor

NONE: Mapping[str, float] = MappingProxyType({})
VERSIONS = 50  # that are kept, the one in force among them; nobody undoes more


@dataclass(frozen=True)
class StoredPlan:
    """A plan as shown, with the ETag of the stored one."""

    document: PlanDocument
    etag: str


def get_plan(case: CaseFolder, version: int | None = None) -> StoredPlan:
    """The plan in force, or an earlier version; an empty one before the first.

    Raises NotFound for a version that is not kept, and when the case is gone.
    """
    content = case.content(PLAN)
    if version is None:
        if content is None:
            case.document()  # NotFound when the case is gone
            return StoredPlan(PlanDocument(), NOTHING)
        return _shown(case, content, PLAN)
    found = None if content is None else _shown(case, content, PLAN)
    if found is not None and found.document.version == version:
        return found
    name = _version_name(version)
    kept = case.content(name)
    if kept is None:
        raise NotFound("This version of the plan is not kept any more.")
    shown = _shown(case, kept, name)
    return StoredPlan(shown.document.model_copy(update={"version": version}), shown.etag)


def plan_versions(case: CaseFolder) -> list[int]:
    """The numbers of the versions that are kept, the newest last."""
    numbers = set(_kept_numbers(case))
    now = get_plan(case).document.version
    return sorted(numbers | ({now} if now else set()))


def put_plan(
    case: CaseFolder, items: Sequence[PlanItem], seen: str | None = None, *, scans: Collection[str] | None = None
) -> StoredPlan:
    """Replaces the plan whose ETag is `seen` (None: whichever it is).

    Raises Changed when another one is there by now, Conflict for an item of a scan that is not here, perhaps since a
    moment ago, NotFound when the case is gone.
    """
    with case.writing():
        content = case.content(PLAN)
        etag = NOTHING if content is None else etag_of(content)
        if seen is not None and seen != etag:
            raise Changed(etag)
        here = case.scan_ids() if scans is None else scans
        elsewhere = next((item.id for item in items if item.scan not in here), None)
        if elsewhere is not None:
            raise Conflict(f'The scan of the item "{elsewhere}" was deleted or moved meanwhile; take the item out.')
        return write_plan(case, items, whole=True)


def put_items_of_scan(case: CaseFolder, scan_id: str, kind: str, items: Sequence[PlanItem]) -> StoredPlan:
    """Replaces the items of one kind that were made on the scan, whatever else the plan holds.  Raises NotFound."""
    with case.writing():
        case.check_scan(scan_id)
        plan = stored_plan(case)
        others = [item for item in plan.items if (item.scan, item.kind) != (scan_id, kind)]
        return write_plan(case, [*others, *renamed(items, others)], plan.whole)


def add_lesions(
    case: CaseFolder,
    scan_id: str,
    lesions: Sequence[BallInside],
    segments: Sequence[TakenSegment],
    notes: Sequence[str],
) -> TakenLesions:
    """Adds lesions of another file (mm, the scan's frame) to what is planned, without those that are there already.

    Raises NotFound, Conflict where the plan has no room for them.
    """
    with case.writing():
        case.check_scan(scan_id)
        plan = stored_plan(case)
        planned = [item for item in plan.items if isinstance(item, PlanLesion)]
        known = [BallInside(one.name, np.array(one.center), one.radius_mm) for one in planned if one.scan == scan_id]
        found = taken(lesions, segments, notes, known, [one.name for one in planned])
        new = [
            PlanLesion(
                id=new_id(), scan=scan_id, name=each.name, center=each.center.tolist(), radius_mm=float(each.radius)
            )
            for each in found.lesions
            if each.is_new
        ]
        if len(plan.items) + len(new) > ITEMS:
            raise Conflict(f"This plan has {len(plan.items)} items, of {ITEMS} at most; take some out first.")
        if new:
            write_plan(case, [*plan.items, *new], plan.whole)
    return found


def stored_plan(case: CaseFolder) -> PlanDocument:
    """The plan in the sizes that its scans have now, with items of scans that are not here."""
    return _in_sizes(case, case.read(PLAN, PlanDocument) or PlanDocument())


def _in_sizes(case: CaseFolder, document: PlanDocument) -> PlanDocument:
    """Each item in the size that its scan has now; of a scan that is not here as it stands."""
    now = _sizes(case, document.items, document.sizes)
    if now == document.sizes:
        return document
    factors = {scan: now.get(scan, 1.0) / document.sizes.get(scan, 1.0) for scan in {*now, *document.sizes}}
    items = [times(item, factors.get(item.scan, 1.0)) for item in document.items]
    return document.model_copy(update={"items": items, "sizes": now})


def times(item: PlanItem, factor: float) -> PlanItem:
    """The item with its places times the factor; what was said in millimetres of the patient stays."""
    if isinstance(item, PlanLine):
        return item.model_copy(update={"points": [[factor * value for value in point] for point in item.points]})
    if isinstance(item, PlanLesion):
        return item.model_copy(update={"center": [factor * value for value in item.center]})
    if isinstance(item, PlanNote) and item.point is not None:
        return item.model_copy(update={"point": [factor * value for value in item.point]})
    return item


def _sizes(case: CaseFolder, items: Sequence[PlanItem], known: Mapping[str, float]) -> dict[str, float]:
    """The items' scans that are larger or smaller than their files, by how much; `known` of scans that are not here."""
    here = case.scan_ids()
    scans = sorted({item.scan for item in items})
    found = {scan: kept_factor(case.scan_folder(scan)) if scan in here else known.get(scan, 1.0) for scan in scans}
    return {scan: factor for scan, factor in found.items() if factor != 1.0}


def write_plan(
    case: CaseFolder, items: Sequence[PlanItem], whole: bool, coming: Mapping[str, float] = NONE
) -> StoredPlan:
    """Puts a new version in force; under `writing`.  The one before is linked into the earlier ones first.

    `coming`: sizes of scans that are on the way into the case.
    """
    before = case.content(PLAN)
    known = {} if before is None else read_document(PlanDocument, before, PLAN).sizes
    number = 0 if before is None else _keep_version(case, before)
    document = PlanDocument(
        items=list(items),
        sizes=_sizes(case, items, {**known, **coming}),
        version=max([number, *_kept_numbers(case)]) + 1,
        whole=whole,
        written_at=utc_now(),
    )
    content = content_of(document.model_copy(update={"patient": None, "scans": []}))
    put(case.path, PLAN, content)
    for old in _kept_numbers(case):
        if old <= document.version - VERSIONS:
            (case.path / _version_name(old)).unlink(missing_ok=True)
    return _shown(case, content, PLAN)


def forget_items(case: CaseFolder, scan_id: str) -> None:
    """Takes the items of a scan that is not here any more out of the plan and of all its versions; under `writing`.

    Who has seen the plan before cannot write it again.  May be called repeatedly.
    """
    plan = stored_plan(case)
    kept = [item for item in plan.items if item.scan != scan_id]
    if len(kept) != len(plan.items):
        write_plan(case, kept, plan.whole)
    for number in _kept_numbers(case):
        _rewrite(case, _version_name(number), lambda item: item.scan != scan_id)


def renamed(items: Sequence[PlanItem], others: Sequence[PlanItem]) -> list[PlanItem]:
    """The items with ids that none of the others has."""
    taken, found = {item.id for item in others}, []
    for item in items:
        wanted, count = item.id, 1
        while item.id in taken:
            count += 1
            item = item.model_copy(update={"id": f"{wanted[:56]}-{count}"})
        taken.add(item.id)
        found.append(item)
    return found


def _rewrite(case: CaseFolder, name: str, wanted: Callable[[PlanItem], bool]) -> None:
    document = case.read(name, PlanDocument)
    if document is not None and not all(map(wanted, document.items)):
        left = document.model_copy(update={"items": [item for item in document.items if wanted(item)]})
        put(case.path, name, content_of(left))


def _keep_version(case: CaseFolder, content: bytes) -> int:
    """Links the plan in force among the earlier ones; its number there, another than its own where that is taken."""
    numbers = _kept_numbers(case)
    number = read_document(PlanDocument, content, PLAN).version
    if number in numbers and case.content(_version_name(number)) != content:
        number = max(numbers) + 1
    target = case.path / _version_name(number)
    target.parent.mkdir(mode=0o700, exist_ok=True)
    if not target.exists():
        link = case.path / f"{PART}link"
        try:
            os.link(case.path / PLAN, link)
        except OSError:  # a file system without hard links
            put(case.path, _version_name(number), content)
        else:
            replace(link, target)  # it reaches the disk with the plan that follows; nobody waits for it alone
    return number


def _kept_numbers(case: CaseFolder) -> list[int]:
    try:
        names = os.listdir(case.path / PLANS)
    except FileNotFoundError:
        return []
    return [int(name[:-5]) for name in names if name.endswith(".json") and name[:-5].isdecimal()]


def _version_name(number: int) -> str:
    return f"{PLANS}/{number:06}.json"


def _shown(case: CaseFolder, content: bytes, name: str) -> StoredPlan:
    """The plan without items of scans that are not here."""
    document, here = _in_sizes(case, read_document(PlanDocument, content, name)), case.scan_ids()
    items = [item for item in document.items if item.scan in here]
    return StoredPlan(document.model_copy(update={"items": items}), etag_of(content))
