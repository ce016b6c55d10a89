"""What the views of one app share: its settings, service, model and counters, found from the request at hand."""

from dataclasses import dataclass, field

from flask import current_app

from breastrig.api.access.rate_limits import RateLimits
from breastrig.api.big_answers import BigAnswers
from breastrig.api.config import Config
from breastrig.api.metrics import Metrics
from breastrig.api.passcode_delays import PasscodeDelays
from breastrig.api.served_model import ServedModel
from breastrig.service.service import Service

KEY = "breastrig"


@dataclass(frozen=True, eq=False)
class AppContext:
    """Made once by `create_app`; the counters live as long as the app."""

    config: Config
    service: Service
    model: ServedModel
    metrics: Metrics
    rates: RateLimits = field(default_factory=RateLimits)
    passcode_delays: PasscodeDelays = field(default_factory=PasscodeDelays)
    big_answers: BigAnswers = field(default_factory=BigAnswers)


def app_context() -> AppContext:
    """That of the app which answers the current request."""
    found = current_app.extensions[KEY]
    assert isinstance(found, AppContext)
    return found
