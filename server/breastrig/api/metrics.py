"""Metrics for Prometheus: numbers of requests, uploads and fits, never whose.

A route is named by its pattern, so no id of a scan or fit becomes a label. The numbers of fits come from the table at
the moment of asking: they count from the beginning of the data folder, and a restart does not reset them.
"""

import time
from collections.abc import Iterator
from typing import Any

from apiflask import APIFlask
from flask import Response, g, request
from prometheus_client import CollectorRegistry, Counter, Histogram
from prometheus_client.core import GaugeMetricFamily, Metric
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from prometheus_client.registry import Collector

from breastrig.api.request_log import BEGAN, route_of_request
from breastrig.index.questions import count_by_state
from breastrig.service.service import Service
from breastrig.storage.deletion import count_left
from breastrig.storage.documents.fits import STATES

BUCKETS_S = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)  # answers take milliseconds, uploads and proposals seconds
FIT_BUCKETS_S = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 120.0)  # a fit takes about a second, 120 s is its limit


class Metrics:
    """One registry for each application."""

    def __init__(self, service: Service) -> None:
        self.registry = CollectorRegistry()
        self.registry.register(_Fits(service))
        labels = ("method", "route", "status")
        self._requests = Counter("breastrig_requests", "Requests answered", labels, registry=self.registry)
        self._seconds = Histogram(
            "breastrig_request_seconds",
            "Until the answer begins",
            ("method", "route"),
            buckets=BUCKETS_S,
            registry=self.registry,
        )
        self._uploads = Counter("breastrig_uploads", "Scans sent, kept or refused", ("kept",), registry=self.registry)
        self._fits = Histogram(
            "breastrig_fit_seconds",
            "How long fits ran that ended since the start of the server",
            ("state",),
            buckets=FIT_BUCKETS_S,
            registry=self.registry,
        )
        service.on_fit_end(lambda state, seconds: self._fits.labels(state).observe(seconds))

    def count(self, response: Response) -> None:
        """Counts the request at hand."""
        method, route = route_of_request()
        self._requests.labels(method, route, str(response.status_code)).inc()
        began = g.get(BEGAN)
        if began is not None:
            self._seconds.labels(method, route).observe(time.perf_counter() - began)
        if (request.endpoint, method) == ("scans.upload_scan", "POST"):
            self._uploads.labels("yes" if response.status_code == 201 else "no").inc()

    def text(self) -> tuple[bytes, str]:
        """The metrics as text, and its content type."""
        return generate_latest(self.registry), CONTENT_TYPE_LATEST


class _Fits(Collector):
    """Fits by state, asked from the table at each scrape."""

    def __init__(self, service: Service) -> None:
        self._service = service

    def collect(self) -> Iterator[Metric]:
        counts = self._service.storage.index.asked(count_by_state)
        states = GaugeMetricFamily("breastrig_fits", "Fits that are kept, by state", labels=["state"])
        for state in STATES:
            states.add_metric([state], counts.get(state, 0))
        yield states
        yield GaugeMetricFamily("breastrig_queue_length", "Fits that wait for a worker", counts.get("queued", 0))
        yield GaugeMetricFamily(
            "breastrig_places_not_removed",
            "Folders of deleted scans and fits whose files could not be removed yet",
            count_left(self._service.storage),
        )
        yield GaugeMetricFamily("breastrig_workers", "Fits that can run at once", self._service.workers)


def register_metrics(app: APIFlask, metrics: Metrics) -> None:
    """Counts every answer, those of the guards too."""

    @app.before_request
    def begin() -> None:
        setattr(g, BEGAN, time.perf_counter())

    @app.after_request
    def end(response: Any) -> Any:
        metrics.count(response)
        return response
