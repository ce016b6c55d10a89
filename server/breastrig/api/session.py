"""The cookie of a browser that has signed in: a signed time, valid until it is too old or the token is another."""

from flask import Response, request
from itsdangerous import BadData, URLSafeTimedSerializer

COOKIE = "breastrig_session"
LASTS_S = 12 * 3600  # a working day; then the token is asked for again


def start_session(response: Response, token: str) -> None:
    """Scripts cannot read the cookie, other sites' pages cannot make the browser send it."""
    value = _signer(token).dumps("signed in")
    response.set_cookie(
        COOKIE, value, max_age=LASTS_S, path="/", secure=request.is_secure, httponly=True, samesite="Strict"
    )


def end_session(response: Response) -> None:
    response.delete_cookie(COOKIE, path="/", secure=request.is_secure, httponly=True, samesite="Strict")


def in_session(token: str) -> bool:
    """Whether the request comes from a browser that has signed in with this token."""
    value = request.cookies.get(COOKIE)
    if value is None:
        return False
    try:
        return bool(_signer(token).loads(value, max_age=LASTS_S) == "signed in")
    except BadData:
        return False


def _signer(token: str) -> URLSafeTimedSerializer:
    return URLSafeTimedSerializer(token, salt="breastrig session")
