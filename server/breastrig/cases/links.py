"""Share links of a fit: what is kept of them in the case.  Their secrets are in the index alone.

What a link shows is a copy in a folder of its own, `shown-N`; another one takes its place by a new N in `link.json`.
"""

from pathlib import Path

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder, remove_tree, utc_now
from breastrig.cases.documents import LinkDocument, content_of
from breastrig.cases.fits import get_fit
from breastrig.cases.layout import fit_part, link_part, new_id
from breastrig.cases.writing import put
from breastrig.core.errors import Conflict, NotFound

OVER = "This link is over; make a new one."


def add_link(case: CaseFolder, scan_id: str, fit_id: str, link: LinkDocument, shown: Path, link_id: str = "") -> str:
    """Keeps a link with the folder of what it shows, made in `incoming`; its id.

    Raises NotFound, Conflict when the fit is not done.
    """
    link_id = link_id or new_id()
    with case.writing():
        fit = get_fit(case, scan_id, fit_id)
        if fit.state != "done":
            raise Conflict(f"This fit has no result to share: it is {fit.state}.")
        part = link_part(scan_id, fit_id, link_id)
        case.put_folder(shown, f"{part}/{layout.SHOWN}1")
        document = link.model_copy(update={"shown": 1, "shown_at": utc_now()})
        put(case.path, f"{part}/{layout.LINK}", content_of(document))
    return link_id


def get_link(case: CaseFolder, scan_id: str, fit_id: str, link_id: str) -> LinkDocument:
    """The link. Raises NotFound."""
    case.check_scan(scan_id)
    found = case.read(f"{link_part(scan_id, fit_id, link_id)}/{layout.LINK}", LinkDocument)
    if found is None:
        raise NotFound("This fit has no such share.")
    return found


def links_of_fit(case: CaseFolder, scan_id: str, fit_id: str) -> dict[str, LinkDocument]:
    """{id: link}, the first that was made first.  Raises NotFound."""
    get_fit(case, scan_id, fit_id)
    folder = case.path / fit_part(scan_id, fit_id) / layout.LINKS
    names = [each.name for each in folder.iterdir() if layout.ID.fullmatch(each.name)] if folder.is_dir() else []
    whole = [name for name in names if (folder / name / layout.LINK).is_file()]
    found = {name: get_link(case, scan_id, fit_id, name) for name in whole}
    return dict(sorted(found.items(), key=lambda one: (one[1].created_at, one[0])))


def refresh_link(case: CaseFolder, scan_id: str, fit_id: str, link_id: str, shown: Path) -> LinkDocument:
    """Lets the link show another folder, made in `incoming`, from now on. Raises NotFound, Conflict when it is over."""
    with case.writing():
        link = get_link(case, scan_id, fit_id, link_id)
        if not is_valid(link, utc_now()):
            raise Conflict(OVER)
        part = link_part(scan_id, fit_id, link_id)
        number = 1 + max(link.shown, *(_number(each) for each in _shown(case.path / part)), 0)
        case.put_folder(shown, f"{part}/{layout.SHOWN}{number}")
        changed = link.model_copy(update={"shown": number, "shown_at": utc_now()})
        put(case.path, f"{part}/{layout.LINK}", content_of(changed))
        _remove_others(case.path / part, number)
    return changed


def end_link(case: CaseFolder, scan_id: str, fit_id: str, link_id: str) -> None:
    """Removes the link's content: it is revoked, or its time is over. Raises NotFound, OSError."""
    with case.writing():
        link, now = get_link(case, scan_id, fit_id, link_id), utc_now()
        part = link_part(scan_id, fit_id, link_id)
        revoked = link.revoked_at or (now if now < link.expires_at else None)
        put(
            case.path,
            f"{part}/{layout.LINK}",
            content_of(link.model_copy(update={"shown": 0, "revoked_at": revoked})),
        )
        _remove_others(case.path / part, 0)


def is_valid(link: LinkDocument, now: str) -> bool:
    """Whether it has neither expired nor been revoked at a time (ISO 8601, UTC)."""
    return link.revoked_at is None and now < link.expires_at and link.shown > 0


def _shown(folder: Path) -> list[Path]:
    return [each for each in folder.glob(f"{layout.SHOWN}*") if each.name.removeprefix(layout.SHOWN).isdecimal()]


def _number(folder: Path) -> int:
    return int(folder.name.removeprefix(layout.SHOWN))


def _remove_others(folder: Path, kept: int) -> None:
    for each in _shown(folder):
        if _number(each) != kept:
            remove_tree(each)
