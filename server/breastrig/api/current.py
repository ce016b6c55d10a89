"""The service behind the request at hand."""

from dataclasses import dataclass

from flask import current_app

from breastrig.api.config import Config
from breastrig.api.model_library import ModelLibrary
from breastrig.jobs.service import Service

KEY = "breastrig"


@dataclass(frozen=True, eq=False)
class Behind:
    config: Config
    service: Service
    models: ModelLibrary


def behind() -> Behind:
    """What `create_app` was given."""
    found = current_app.extensions[KEY]
    assert isinstance(found, Behind)
    return found
