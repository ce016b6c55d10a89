"""Share links, the owner's side: make one, see who opens it, revoke it."""

from datetime import UTC, datetime, timedelta

from apiflask import APIBlueprint
from werkzeug.security import generate_password_hash

from breastrig.api.app_context import service, storage
from breastrig.api.language import current_language
from breastrig.api.routes.shares.share_credential import new_token, token_sha256
from breastrig.api.share_limits import WRONG_PASSCODES
from breastrig.api.wire import common as wire
from breastrig.api.wire import shares as wire_shares
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.documents.shares import (
    StoredShare,
    get_share,
    openings_of,
    shares_page,
    unlock_share,
)
from breastrig.storage.folders import new_id
from breastrig.storage.storage import iso_utc, utc_now

SHARES_TAG = {"name": "shares", "description": "Show one result to somebody: read-only links that end."}
OPENINGS_SHOWN = 100

shares = APIBlueprint("shares", __name__, url_prefix="/api/fits", tag=SHARES_TAG)


@shares.post("/<fit_id>/shares")
@shares.input(wire_shares.ShareRequest)
@shares.output(wire_shares.ShareMade, status_code=201, description="The link; it is shown only now")
@shares.doc(operation_id="makeShare", responses={409: "The fit is not done"})
def make_share(fit_id: str, json_data: wire_shares.ShareRequest) -> tuple[wire_shares.ShareMade, int, dict[str, str]]:
    """Make a read-only link to a fit's result

    It shows what stands now (the plan, what is cut away), whatever is changed later, until it is refreshed.
    The secret is in the address's fragment, which browsers do not send to servers.  It is stored only as a hash:
    the link cannot be shown again.
    """
    now, token = datetime.now(UTC), new_token()
    share = StoredShare(
        id=new_id(),
        fit=fit_id,
        created_at=iso_utc(now),
        expires_at=iso_utc(now + timedelta(days=json_data.expires_in_days)),
        scan=json_data.scan,
        passcode_hash=generate_password_hash(json_data.passcode) if json_data.passcode else None,
        notes=json_data.notes,
        snapshot=None,
        snapshot_at=None,
    )
    share = service.shares.add(share, token_sha256(token), current_language())
    answer = wire_shares.ShareMade(url=f"/s#{token}", **share_answer(share).model_dump())
    return answer, 201, {"Location": answer.links.self}


@shares.get("/<fit_id>/shares")
@shares.input(wire.PageQuery, location="query")
@shares.output(wire_shares.SharePage)
@shares.doc(operation_id="listShares")
def list_shares(fit_id: str, query_data: wire.PageQuery) -> wire_shares.SharePage:
    """The links to a fit's result, the newest first"""
    get_fit(storage, fit_id)
    rows, before = shares_page(storage, fit_id, query_data.limit, query_data.before)
    more = query_data.next_page(f"/api/fits/{fit_id}/shares", before=before)
    return wire_shares.SharePage(shares=[share_answer(row) for row in rows], next=more)


@shares.get("/<fit_id>/shares/<share_id>")
@shares.output(wire_shares.ShareWithOpenings)
@shares.doc(operation_id="getShare")
def show_share(fit_id: str, share_id: str) -> wire_shares.ShareWithOpenings:
    """One link, and when it was opened"""
    share = get_share(storage, fit_id, share_id)
    opened = openings_of(storage, share.id, OPENINGS_SHOWN)
    return wire_shares.ShareWithOpenings(opened_at=opened, **share_answer(share).model_dump())


@shares.delete("/<fit_id>/shares/<share_id>")
@shares.output({}, status_code=204)
@shares.doc(operation_id="revokeShare")
def remove_share(fit_id: str, share_id: str) -> tuple[str, int]:
    """Revoke a link

    It is closed at once, for those too who have it open or are loading a file, and what it showed is removed.  It stays
    in the list until the fit is deleted.  Revoking what is not there is no error.
    """
    service.shares.revoke(fit_id, share_id)
    return "", 204


@shares.post("/<fit_id>/shares/<share_id>/refresh")
@shares.output(wire_shares.Share)
@shares.doc(operation_id="refreshShare", responses={409: "The link is over"})
def refresh(fit_id: str, share_id: str) -> wire_shares.Share:
    """Show the present state

    The plan and what is cut away as they are now, to all who have the link.
    """
    return share_answer(service.shares.refresh(fit_id, share_id, current_language()))


@shares.post("/<fit_id>/shares/<share_id>/unlock")
@shares.output(wire_shares.Share)
@shares.doc(operation_id="unlockShare")
def unlock(fit_id: str, share_id: str) -> wire_shares.Share:
    """Let a link take passcodes again

    For one that wrong passcodes have locked: as many may be tried again.  The count goes on.
    """
    unlock_share(storage, fit_id, share_id)
    return share_answer(get_share(storage, fit_id, share_id))


def share_answer(row: StoredShare) -> wire_shares.Share:
    """The stored row as the owner sees it."""
    is_locked = row.is_locked(WRONG_PASSCODES)
    return wire_shares.Share.of(
        row,
        is_open=row.is_valid(utc_now()) and not is_locked,
        is_locked=is_locked,
        shown_at=row.snapshot_at,
        has_passcode=row.passcode_hash is not None,
        last_wrong_passcode_at=row.last_wrong_at,
        links=wire_shares.ShareLinks.at(f"/api/fits/{row.fit}/shares/{row.id}"),
    )
