"""The passcode of a share link: who gives the right one gets in, whatever others have guessed.

Each address that guesses wrong waits longer and longer; others do not wait.  Beyond a number of wrong passcodes in all
the link takes none any more, until its owner, who sees that number, unlocks it.  So no more than that number can ever
be tried, however many addresses there are.
"""

import threading

from flask import request
from werkzeug.security import check_password_hash

from breastrig.api.app_context import app_context
from breastrig.api.errors import refuse
from breastrig.api.routes.shares.share_credential import LOCKED
from breastrig.api.share_limits import WRONG_PASSCODES
from breastrig.api.trusted_proxy import client_of
from breastrig.storage.rows.shares import ShareRow, note_wrong_passcode
from breastrig.storage.storage import utc_now

_CHECKS = threading.BoundedSemaphore(2)  # at once: each takes 32 MB and a core for a twentieth of a second


def check_passcode(share: ShareRow, passcode: str | None) -> None:
    """Raises 403 for a wrong or missing passcode, 423 when the link takes none, 429 for an address that has to wait."""
    if share.passcode_hash is None:
        return
    if share.is_locked(WRONG_PASSCODES):
        raise refuse(423, LOCKED)
    if passcode is None:
        raise refuse(403, "This link needs a passcode; ask the person who sent it.")
    context, client = app_context(), client_of(request.remote_addr)
    seconds = context.passcode_delays.begin(share.id, client)
    if seconds:
        raise refuse(
            429,
            f"Too many wrong passcodes came from here; try again in {seconds} s.",
            {"Retry-After": str(seconds)},
        )
    with _CHECKS:
        is_right = check_password_hash(share.passcode_hash, passcode)
    if not is_right:
        if not note_wrong_passcode(context.service.storage, share.id, utc_now(), WRONG_PASSCODES):
            raise refuse(423, LOCKED)  # as a right one is answered then: nobody is to learn which it was
        raise refuse(403, "This is not the link's passcode; ask the person who sent it.")
    context.passcode_delays.was_right(share.id, client)
