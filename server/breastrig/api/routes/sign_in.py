"""Sign-in with the token, or with `--users` at the hospital's own provider or proxy.

With the token, so that the browser may ask for the rest: a page, plain HTML without script, or the address
with the token in it that `breastrig serve` prints.

A hospital has one address for all, so whoever guesses there must not keep colleagues out: the right token opens however
many wrong ones came before it, as it does in the Authorization header. Wrong ones are refused beyond a small number.
Guessing is bounded by a larger number of tries from one address, beyond which no token is checked: at 600 a minute, 16
random hexadecimal digits take more than 10^10 years.
"""

import hmac
from functools import partial

from flask import Blueprint, Response, render_template, request, url_for
from werkzeug.exceptions import HTTPException

from breastrig.api.access.callers import person_in_browser
from breastrig.api.access.provider import NotSignedIn
from breastrig.api.access.session import end_session, start_session
from breastrig.api.answers import CHECK_AGAIN, bytes_answer
from breastrig.api.app_context import app_context, config, storage
from breastrig.api.language import current_language, in_language
from breastrig.languages.translation import said

sign_in = Blueprint("sign_in", __name__, template_folder="templates")

# Under "no-referrer", which all else has, browsers say "Origin: null" for a form: it would look foreign.
PAGE_HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "same-origin"}
WRONG = "This is not the token. It may be another one since the service was started again."
NOT_NEEDED = "This service needs no token."


@sign_in.get("/sign-in")
def ask() -> Response:
    return _page()


@sign_in.post("/sign-in")
def answer() -> Response:
    return sign_in_with(request.form.get("token", "").strip())


def sign_in_with(given: str) -> Response:
    """Sets the cookie and leads to the page's own address, or asks again."""
    token = config.token
    if token is None or config.people is not None:
        return lead_to("/")
    _count("sign-in tried")
    if not hmac.compare_digest(given.encode("utf-8", "replace"), token.encode()):
        _count("sign-in")
        return _page(WRONG, 401)
    response = lead_to("/")
    start_session(response, config)
    return response


@sign_in.get("/sign-in/start")
def leave_for_provider() -> Response:
    """To the provider, where there is one"""
    provider = app_context().provider
    _count("sign-in tried")
    if provider is None:
        return lead_to("/sign-in")
    try:
        response = provider.leave_for(url_for("sign_in.come_back", _external=True))
    except NotSignedIn as error:
        return _page(str(error), 502)
    end_session(response, config, storage)  # of whoever was here before
    response.headers["Cache-Control"] = "no-store"
    return response


@sign_in.get("/sign-in/callback")
def come_back() -> Response:
    """From the provider, which names a code; it leads to the page's own address and nowhere else"""
    provider = app_context().provider
    _count("sign-in tried")
    if provider is None:
        return lead_to("/sign-in")
    try:
        person = provider.person()
    except NotSignedIn as error:
        return _page(str(error), 401)
    response = lead_to("/")
    start_session(response, config, person)
    return response


@sign_in.post("/sign-out")
def leave() -> Response:
    response = lead_to("/sign-in")
    # What the browser keeps of patients.  Not "cookies": that would be those of the whole domain, other programs' too.
    response.headers["Clear-Site-Data"] = '"cache", "storage"'
    end_session(response, config, storage)
    return response


@sign_in.get("/sign-in/style.css")
def style() -> Response:
    return bytes_answer(render_template("sign_in.css").encode(), "text/css", CHECK_AGAIN)


def _page(problem: str = "", status: int = 200) -> Response:
    token, people = config.token, config.people
    person = person_in_browser(config, storage)
    by = "people" if app_context().provider else "proxy" if people else "token" if token else ""
    note = problem if by else NOT_NEEDED
    shown = {"by": by, "note": note, "signed_in": person is not None, "name": person and people and person.name}
    language = current_language()
    html = render_template("sign_in.html", **shown, language=language, t=partial(said, language=language))
    return in_language(Response(html, status, mimetype="text/html", headers=PAGE_HEADERS))


def _count(purpose: str) -> None:
    """Counts the request; raises the page that asks to wait when it is one too many."""
    seconds = app_context().rates.wait_s(purpose)
    if seconds:
        refused = _page(f"Too many attempts. Try again in {seconds} s.", 429)
        refused.headers["Retry-After"] = str(seconds)
        raise HTTPException(response=refused)


def lead_to(place: str) -> Response:
    """Another address of ours."""
    return Response(status=303, headers={"Location": place, "Cache-Control": "no-store"})
