"""Who comes with a share link: the secret of the link, and for links with a passcode the proof that it was given.

The secret is 192 random bits in the link's fragment, which browsers do not send; the page posts it once and gets a
cookie.  The cookie is asked anew at every call, so an expired or revoked link is closed at once.
"""

import hashlib
import hmac
import secrets
from datetime import datetime

from flask import Response, request

from breastrig.api.current import behind
from breastrig.api.security import refuse
from breastrig.storage.shares import ShareRow, share_of_token
from breastrig.storage.storage import utc_now

COOKIE = "breastrig_share"
PATH = "/api/shared"  # the cookie is sent nowhere else
LASTS_S = 12 * 3600


def new_token() -> str:
    """192 random bits as 32 URL-safe characters."""
    return secrets.token_urlsafe(24)


def token_sha256(token: str) -> str:
    """What is stored of the secret; it has too many bits to be found from its hash."""
    return hashlib.sha256(token.encode("utf-8", "replace")).hexdigest()


def share_behind(token: str) -> ShareRow:
    """The share that the secret opens.  Raises 404 for none, 410 for one that is over."""
    share = share_of_token(behind().service.storage, token_sha256(token))
    if share is None:
        raise refuse(404, "This link opens nothing; ask the person who sent it for a new one.")
    if not share.is_open(utc_now()):
        raise refuse(410, "This link has expired or was revoked; ask the person who sent it for a new one.")
    return share


def hand_out(response: Response, share: ShareRow, token: str) -> None:
    """The cookie for the calls that follow."""
    left = datetime.fromisoformat(share.expires_at) - datetime.fromisoformat(utc_now())
    seconds = int(min(LASTS_S, max(1.0, left.total_seconds())))
    response.set_cookie(
        COOKIE,
        f"{token}.{_proof(share, token)}",
        max_age=seconds,
        path=PATH,
        secure=request.is_secure,
        httponly=True,
        samesite="Strict",
    )


def visited_share() -> ShareRow:
    """The share of the request's cookie.  Raises 401 without one, 404 and 410 as `share_behind`."""
    token, dot, proof = request.cookies.get(COOKIE, "").partition(".")
    if not dot:
        raise refuse(401, "Open the share link first; it ends in #, followed by its secret.")
    share = share_behind(token)
    if not hmac.compare_digest(proof.encode("utf-8", "replace"), _proof(share, token).encode()):
        raise refuse(401, "Open the share link again; its passcode is needed.")
    return share


def _proof(share: ShareRow, token: str) -> str:
    """Only the server can make it: the salted hash of the passcode never leaves it."""
    key = (share.passcode_hash or "no passcode").encode()
    return hmac.new(key, token.encode("utf-8", "replace"), hashlib.sha256).hexdigest()
