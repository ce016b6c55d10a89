"""Sign-in at an OpenID provider: authorization code flow with PKCE, state and nonce, all of it Authlib's.

What waits between leaving for the provider and coming back is in a signed cookie of this browser's that is good for
some minutes and sent to `/sign-in` alone.  It is Lax, as the way back begins at another site.
"""

import logging
import secrets
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import timedelta
from typing import TYPE_CHECKING, Any

from flask import Flask, Response, request, session
from flask.sessions import SecureCookieSessionInterface

from breastrig.api.access.person import Person
from breastrig.api.people.people import People
from breastrig.core.errors import BadSettings, BreastRigError

if TYPE_CHECKING:
    from authlib.integrations.flask_client import FlaskOAuth2App

PATH = "/sign-in"
MINUTES = 15  # to find the password
TIMEOUT_S = 10.0  # of a question to the provider
LATE_S = 120  # that clocks may differ
SIGNED_BY = ("RS256", "RS384", "RS512", "PS256", "PS384", "PS512", "ES256", "ES384", "ES512", "EdDSA", "Ed25519")
BEGAN = "began"
log = logging.getLogger(__name__)


class NotSignedIn(BreastRigError):
    """The provider has not said who it is, in a sentence."""


class _Waiting(SecureCookieSessionInterface):
    """Flask's own signed cookie, for the way to the provider and back."""

    def get_cookie_secure(self, app: Flask) -> bool:
        return request.is_secure


class Provider:
    """The provider that the file of users names."""

    def __init__(self, app: Flask, people: People) -> None:
        """Raises BadSettings where the extra `users` is not installed.  The provider itself is asked when needed."""
        try:
            from authlib.integrations.flask_client import OAuth
        except ImportError as error:
            raise BadSettings('Sign-in at a provider needs Authlib; install "breastrig[users]".') from error
        app.secret_key = people.key
        app.session_interface = _Waiting()
        app.permanent_session_lifetime = timedelta(minutes=MINUTES)
        app.config |= {
            "SESSION_COOKIE_NAME": f"breastrig_sign_in_{secrets.token_hex(4)}",  # cookies ignore ports
            "SESSION_COOKIE_PATH": PATH,
            "SESSION_COOKIE_SAMESITE": "Lax",
        }
        assert people.issuer is not None
        self._people, self._issuer = people, people.issuer
        secret = people.secret()
        asked: dict[str, Any] = {"scope": " ".join(people.scopes), "code_challenge_method": "S256"}
        if secret is None:
            asked["token_endpoint_auth_method"] = "none"
        self._client: FlaskOAuth2App = OAuth(app).register(
            "provider",
            client_id=people.client_id,
            client_secret=secret,
            server_metadata_url=f"{self._issuer.rstrip('/')}/.well-known/openid-configuration",
            client_kwargs=asked | {"default_timeout": TIMEOUT_S},
        )

    def leave_for(self, address: str) -> Response:
        """Leads the browser to the provider, which sends it back to `address`.  Raises NotSignedIn."""
        with _said():
            self._metadata()
            session.clear()
            session[BEGAN] = int(time.time())
            extra = {} if self._people.prompt == "none" else {"prompt": self._people.prompt}
            response: Response = self._client.authorize_redirect(address, **extra)
        return response

    def person(self) -> Person:
        """Who has come back from the provider with the request at hand.  Raises NotSignedIn."""
        began = session.get(BEGAN, 0)
        try:
            with _said():
                metadata = self._metadata()
                checked = {
                    "iss": {"essential": True, "values": [self._issuer]},
                    "aud": {"essential": True, "values": [self._people.client_id]},
                }
                token = self._client.authorize_access_token(claims_options=checked, leeway=LATE_S)
                claims: Mapping[str, Any] = token["userinfo"]  # of the ID token, whose signature and nonce were checked
                named = _at(claims, self._people.groups_claim)
                if named is None and "userinfo_endpoint" in metadata:
                    more = self._client.userinfo(token=token)
                    if more["sub"] != claims["sub"]:
                        raise ValueError("userinfo is of somebody else")
                    named, claims = _at(more, self._people.groups_claim), {**more, **claims}
                groups = {named} if isinstance(named, str) else {str(one).lstrip("/") for one in named or ()}
        finally:
            session.clear()
        asked_at = claims.get("auth_time")
        if self._people.prompt == "login" and isinstance(asked_at, int | float) and asked_at < began - LATE_S:
            raise NotSignedIn("The provider did not ask for your password again; sign in once more.")
        name = next((str(claims[one]) for one in ("name", "preferred_username") if claims.get(one)), str(claims["sub"]))
        person = self._people.person(str(claims["sub"]), name, groups)
        if person is None:
            raise NotSignedIn(f"{name} is in none of the groups that may use this service; ask its administrator.")
        return person

    def _metadata(self) -> dict[str, Any]:
        """What the provider says of itself.  Raises ValueError where that is another one."""
        found: dict[str, Any] = self._client.load_server_metadata()
        if found.get("issuer") != self._issuer:
            self._client.server_metadata.pop("_loaded_at", None)
            raise ValueError("the provider calls itself otherwise than the file of users does")
        offered = found.get("id_token_signing_alg_values_supported") or ["RS256"]
        found["id_token_signing_alg_values_supported"] = [one for one in offered if one in SIGNED_BY]
        return found


@contextmanager
def _said() -> Iterator[None]:
    """Turns what goes wrong on the way into one sentence; the log has the kind, never a code or token."""
    try:
        yield
    except Exception as error:
        log.warning("nobody was signed in by the provider: %s", getattr(error, "error", None) or type(error).__name__)
        raise NotSignedIn("The sign-in did not succeed; try again, or tell who runs this service.") from error


def _at(claims: Mapping[str, Any], path: str) -> Any:
    """A claim, also one inside of others; None where there is none."""
    found: Any = claims
    for part in (path,) if path in claims else path.split("."):
        found = found.get(part) if isinstance(found, Mapping) else None
    return found
