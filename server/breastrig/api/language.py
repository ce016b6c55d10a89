"""The language of a request, and its answers in it.

The page says its language in a cookie, which also goes with event streams and downloads; browsers and programs without
it by Accept-Language.  What is stored stays English, and so does what is sent to who asks for nothing else.
"""

import json

from flask import Flask, Response, request

from breastrig.languages.catalogue import ENGLISH, LANGUAGES
from breastrig.languages.translation import document_said

COOKIE = "breastrig_language"
FIELDS = frozenset(  # of answers and events, that hold sentences or labels of ours for people
    {
        "detail", "message", "problem", "reason", "reasons", "says", "doubts", "notes", "notice", "limit",
        "label", "parameters.about", "definition", "not_proposed.*", "unit_reason", "size_doubt", "stance_reason",
        "stop_reason", "method", "said.*", "choices.text", "clock.text", "radiology.text", "changes.missing",
        "segments.why", "segments.name",
    }
)  # fmt: skip
TYPED = {  # as people have typed it, or as their file has it
    *(".label", "scans.label", "visits.label"),  # the name of a visit
    *("items.label", "shapes.label", "segments.label"),
}
NAMES = frozenset(field.partition(".")[0 if field.endswith("*") else 2] or field for field in FIELDS)
TYPES = ("application/json", "application/problem+json")


def current_language() -> str:
    """One of LANGUAGES, for the request at hand."""
    said = request.cookies.get(COOKIE)
    return said if said in LANGUAGES else request.accept_languages.best_match(LANGUAGES, ENGLISH) or ENGLISH


def register_language(app: Flask) -> None:
    app.after_request(_in_language)


def event_said(utf8: bytes, language: str) -> bytes:
    """An event's or an answer's JSON in the language; the same bytes where that says nothing else."""
    if language == ENGLISH or not any(b'"%b"' % field.encode() in utf8 for field in NAMES):
        return utf8
    document = json.loads(utf8)
    found = document_said(document, language, _is_field)
    return utf8 if found == document else json.dumps(found, separators=(",", ":")).encode()


def in_language(response: Response) -> Response:
    """The answer, said to be in the language of its request."""
    response.vary.update(("Accept-Language", "Cookie"))
    response.content_language.add(current_language())
    return response


def _is_field(holder: str, name: str) -> bool:
    return f"{holder}.{name}" not in TYPED and not FIELDS.isdisjoint((name, f"{holder}.{name}", f"{holder}.*"))


def _in_language(response: Response) -> Response:
    """The answer's sentences in the language of its request; the model's files are the same for all."""
    if response.mimetype not in TYPES or request.blueprint == "models" or response.status_code in (206, 304):
        return response
    language = current_language()
    in_language(response)
    if language != ENGLISH:
        response.direct_passthrough = False
        content = response.get_data()
        found = event_said(content, language)
        if found is not content:
            etag, is_weak = response.get_etag()
            response.set_data(found)
            if etag is not None:
                response.set_etag(f"{etag}-{language}", bool(is_weak))
    return response
