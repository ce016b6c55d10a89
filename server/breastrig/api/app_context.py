"""The objects that the views of one app share: settings, service, model and counters, by the current request."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from flask import Response, current_app
from werkzeug.local import LocalProxy

from breastrig.api.access.provider import Provider
from breastrig.api.access.rate_limits import RateLimits
from breastrig.api.big_answers import BigAnswers, big_answer
from breastrig.api.config import Config
from breastrig.api.metrics import Metrics
from breastrig.api.passcode_delays import PasscodeDelays
from breastrig.api.served_model import ServedModel, serve_model
from breastrig.service.kept_models import KeptModels
from breastrig.service.service import Service
from breastrig.storage.documents.scans import are_kept
from breastrig.storage.files import OpenedFile
from breastrig.storage.storage import Storage

KEY = "breastrig"


@dataclass(frozen=True, eq=False)
class AppContext:
    """Made once by `create_app`; the counters live as long as the app."""

    config: Config
    service: Service
    model: ServedModel
    metrics: Metrics
    provider: Provider | None = None  # where people sign in
    rates: RateLimits = field(default_factory=RateLimits)
    passcode_delays: PasscodeDelays = field(default_factory=PasscodeDelays)
    big_answers: BigAnswers = field(default_factory=BigAnswers)

    def model_with(self, sha256: str) -> ServedModel:
        """The service's own model, or that of an earlier server, whose fits are kept; the own one for none of them."""
        if sha256 == self.model.rig.sha256:
            return self.model
        return _read_once(self.service.models, sha256)

    def model_of(self, facts: Mapping[str, Any]) -> ServedModel:
        """The model of a stored scan."""
        own, glb = (self.service.models.path_of(each) for each in ({}, facts))
        return self.model if glb == own else _served_once(glb)

    def patients_file(
        self, scans: Collection[str], file: OpenedFile, media_type: str, download_as: str | None = None
    ) -> Response:
        """A file of these scans, or of fits of them, to their owner for as long as all of them are there."""
        storage = self.service.storage
        return big_answer(self.big_answers, file, media_type, lambda: are_kept(storage, scans), download_as=download_as)


@lru_cache(maxsize=2)
def _read_once(models: KeptModels, sha256: str) -> ServedModel:
    with models.at_hand(sha256) as glb:
        return serve_model(glb)


@lru_cache(maxsize=4)
def _served_once(glb: Path | None) -> ServedModel:
    return serve_model(glb)


def app_context() -> AppContext:
    """The context of the app that answers the current request."""
    found = current_app.extensions[KEY]
    assert isinstance(found, AppContext)
    return found


# Of the current request, as Flask's own; what goes on after it, a stream, takes them from its context.
config: Config = LocalProxy(lambda: app_context().config)  # type: ignore[assignment]
service: Service = LocalProxy(lambda: app_context().service)  # type: ignore[assignment]
storage: Storage = LocalProxy(lambda: app_context().service.storage)  # type: ignore[assignment]
