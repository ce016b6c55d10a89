"""The events of a fit, as a stream and page by page.

Both give what is stored, nothing else: whoever opens the stream late, or again, sees the same events with the
same numbers.
"""

import json
from collections.abc import Iterator, Sequence

from apiflask import APIBlueprint
from flask import Response, request

from breastrig.api.answers import file_of
from breastrig.api.app_context import config, service, storage
from breastrig.api.errors import refuse
from breastrig.api.language import current_language, event_said
from breastrig.api.routes.fits import FITS_TAG
from breastrig.api.web_server import GONE
from breastrig.api.wire import common as wire
from breastrig.service.events.feeds import Heartbeat, Queued, StreamItem
from breastrig.storage.documents.events import events_after
from breastrig.storage.documents.fits import get_fit

events = APIBlueprint("events", __name__, url_prefix="/api/fits", tag=FITS_TAG)

STREAM_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
RECONNECT_MS = 1000
TOGETHER = 65_536  # characters that are sent at once
STREAM = file_of("text/event-stream", "Server-sent events; `data` is the event's JSON")


@events.get("/<fit_id>/events")
@events.input(wire.EventQuery, location="query")
@events.doc(
    operation_id="followFit",
    responses={
        200: STREAM,
        204: "The fit has ended and no event is left to send; do not connect again",
        503: "Too many open streams; use events.json",
    },
)
def follow_fit(fit_id: str, query_data: wire.EventQuery) -> Response:
    """Follow a fit: server-sent events

    `id:` is the event's number, `event:` its kind.  Continues after `Last-Event-ID` (or `?after=`), sends comments
    as heartbeats, and closes after done, failed or cancelled.  While the fit waits, an event `queued` without an
    `id:` says its `position` in the queue (1: the next to run) each time that it changes.
    """
    after = max(query_data.after, _last_event_id())
    fit = get_fit(storage, fit_id)
    if fit.ended and fit.last_event <= after:
        return Response(status=204)
    if not service.streams.acquire(blocking=False):
        raise refuse(
            503, "Too many event streams are open; ask events.json instead, or try again later.", {"Retry-After": "5"}
        )
    gone = request.environ.get("asgi.scope", {}).get(GONE)
    response = Response(
        _lines(service.follow(fit_id, after, config.heartbeat_s, gone and gone.is_set), current_language()),
        mimetype="text/event-stream",
        headers=STREAM_HEADERS,
    )
    response.call_on_close(service.streams.release)
    return response


@events.get("/<fit_id>/events.json")
@events.input(wire.EventPageQuery, location="query")
@events.output(wire.EventPage)
@events.doc(operation_id="pollFit")
def poll_fit(fit_id: str, query_data: wire.EventPageQuery) -> Response:
    """Follow a fit by polling: the same events as a list

    The list is complete when `state` has ended and `next` is null.
    """
    state = get_fit(storage, fit_id).state  # first, so that an ended state comes with all of its events
    limit = query_data.limit
    found = events_after(storage, fit_id, query_data.after, limit + 1)
    records = ",".join(f'{{"id":{event.number},"event":{event.json}}}' for event in found[:limit])
    more = None
    if len(found) > limit:
        more = f"/api/fits/{fit_id}/events.json?after={found[limit - 1].number}&limit={limit}"
    return Response(
        f'{{"events":[{records}],"state":"{state}","next":{json.dumps(more)}}}', mimetype="application/json"
    )


def _lines(news: Iterator[Sequence[StreamItem]], language: str) -> Iterator[bytes]:
    """The stream's bytes; events that are known at once are sent at once, so a late reader gets few pieces."""
    text = bytearray(b"retry: %d\n\n" % RECONNECT_MS)
    for together in news:
        for item in together:
            text += _text(item, language)
            if len(text) >= TOGETHER:
                yield bytes(text)
                text.clear()
        if text:
            yield bytes(text)
            text.clear()
    if text:
        yield bytes(text)


def _text(item: StreamItem, language: str) -> bytes:
    if isinstance(item, Heartbeat):
        return b": still here\n\n"
    if isinstance(item, Queued):  # without a number: a viewer who comes again need not hear it
        return b'event: queued\ndata: {"kind":"queued","position":%d}\n\n' % item.position
    return b"id: %d\nevent: %b\ndata: %b\n\n" % (item.number, item.kind.encode(), event_said(item.utf8, language))


def _last_event_id() -> int:
    text = request.headers.get("Last-Event-ID", "").strip()
    if not text:
        return 0
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise refuse(400, "Last-Event-ID must be the number of an event.")
    return int(text)
