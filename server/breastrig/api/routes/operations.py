"""For those who run the service: is it alive, is it ready, how busy is it.

None of it says anything about a patient.  /healthz and /readyz answer everyone, because load balancers have no token;
/metrics answers programs on this machine only, and behind a proxy, which is one of them, whoever brings the token.
"""

from apiflask import APIBlueprint
from flask import Response, request

from breastrig.api.access.callers import has_token
from breastrig.api.access.security import count_guess
from breastrig.api.answers import file_of
from breastrig.api.app_context import app_context, config, service
from breastrig.api.config import is_loopback
from breastrig.api.errors import refuse
from breastrig.api.trusted_proxy import FORWARDED
from breastrig.api.wire import meta as wire_meta

operations = APIBlueprint(
    "operations", __name__, tag={"name": "operations", "description": "Is the service alive, ready, busy."}
)


@operations.get("/healthz")
@operations.output(wire_meta.Health)
@operations.doc(operation_id="health")
def health() -> wire_meta.Health:
    """Answers when the service runs"""
    return wire_meta.Health(status="ok")


@operations.get("/readyz")
@operations.output(wire_meta.Readiness)
@operations.doc(operation_id="ready", responses={503: "Not ready; the sentence says why"})
def ready() -> wire_meta.Readiness:
    """Whether work would be done

    The index can be written, the workers answer, the model can be read.
    """
    troubles = service.readiness.troubles()
    if not app_context().model.is_still_there():
        troubles = (*troubles, "The model's file is gone or another one.")
    if troubles:
        raise refuse(503, " ".join(troubles), {"Retry-After": "5"})
    return wire_meta.Readiness(status="ready")


@operations.get("/metrics")
@operations.doc(
    operation_id="metrics",
    responses={200: file_of("text/plain", "Prometheus' text format"), 403: "Asked from another machine"},
)
def show_metrics() -> Response:
    """Numbers for Prometheus, only to programs on this machine

    Where the service stands behind a proxy, to whoever brings its token as a bearer.
    """
    token = config.token
    from_here = FORWARDED not in request.environ and is_loopback(request.remote_addr or "")
    if not from_here and (token is None or not has_token(token)):
        count_guess(app_context().rates)
        raise refuse(403, "Metrics are shown only to programs on the server itself, and to whoever has its token.")
    content, kind = app_context().metrics.text()
    return Response(content, content_type=kind)
