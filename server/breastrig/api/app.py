"""The Flask application: blueprints, guards, errors.  It owns no process and no thread; `service` does."""

from typing import Any

from apiflask import APIFlask
from flask.json.provider import DefaultJSONProvider

from breastrig.api.access.audited import register_audit
from breastrig.api.access.person import groups_in_reach
from breastrig.api.access.provider import Provider
from breastrig.api.access.security import register_security
from breastrig.api.app_context import KEY, AppContext
from breastrig.api.config import Config
from breastrig.api.errors import register_errors
from breastrig.api.language import register_language
from breastrig.api.metrics import Metrics, register_metrics
from breastrig.api.openapi import finish_document
from breastrig.api.request_log import log_error_of_request, register_request_log
from breastrig.api.routes.administration.audit import audit
from breastrig.api.routes.docs import docs
from breastrig.api.routes.drawings import drawings
from breastrig.api.routes.events import events
from breastrig.api.routes.fits import fits, fits_of_scans
from breastrig.api.routes.meta import meta
from breastrig.api.routes.models import models
from breastrig.api.routes.operations import operations
from breastrig.api.routes.page import PageFile, page
from breastrig.api.routes.patients import owners, patients, plans_of_fits
from breastrig.api.routes.patterns import patterns
from breastrig.api.routes.persons import persons
from breastrig.api.routes.reports import reports
from breastrig.api.routes.results import results
from breastrig.api.routes.scans.of_scans import of_scans
from breastrig.api.routes.scans.scans import scans
from breastrig.api.routes.shares.shared import share_page, shared
from breastrig.api.routes.shares.shares import shares
from breastrig.api.routes.sign_in import sign_in
from breastrig.api.routes.transfers import transfers
from breastrig.api.routes.visits import visits, visits_of_scans
from breastrig.api.served_model import serve_model
from breastrig.api.trusted_proxy import BehindProxy
from breastrig.core.version import __version__
from breastrig.service.service import Service


def create_app(config: Config, service: Service) -> APIFlask:
    """The application around a service, which the caller starts and stops."""
    app = _bare_app()
    app.config["MAX_CONTENT_LENGTH"] = config.uploads.zip_bytes
    metrics = Metrics(service)
    provider = Provider(app, config.people) if config.people is not None and config.people.issuer else None
    app.extensions[KEY] = AppContext(config, service, serve_model(config.model), metrics, provider)
    service.storage.groups_in_reach = groups_in_reach
    register_errors(app, service.storage)
    register_language(app)
    if config.log_requests:
        register_request_log(app)
    register_metrics(app, metrics)  # before the guards, so that what they refuse is counted too
    register_security(app, config, service.storage, app.extensions[KEY].rates)
    register_audit(app, service.audit, service.storage)
    app.wsgi_app = BehindProxy(app.wsgi_app, config.trusted_proxy)  # type: ignore[method-assign]  # as Flask has it
    return app


def openapi_document() -> dict[str, Any]:
    """The API's description; needs no service."""
    document = _bare_app().spec
    assert isinstance(document, dict)
    return document


class _App(APIFlask):
    def log_exception(self, exc_info: Any) -> None:
        """Flask's own line names the address, and so an id."""
        log_error_of_request(exc_info[1])


def _bare_app() -> APIFlask:
    app = _App(
        "breastrig.api",
        title="BreastRig",
        version=__version__,
        spec_path=None,
        docs_path=None,
        static_folder=None,  # type: ignore[arg-type]  # none, as Flask takes it
    )
    app.config["AUTO_SERVERS"] = False
    assert isinstance(app.json, DefaultJSONProvider)
    app.json.sort_keys = False
    app.url_map.merge_slashes = False  # an address has one spelling; no redirects
    app.url_map.converters["page_file"] = PageFile
    for blueprint in (
        scans,
        of_scans,
        drawings,
        patients,
        owners,
        plans_of_fits,
        persons,
        visits,
        visits_of_scans,
        patterns,
        fits,
        fits_of_scans,
        events,
        results,
        reports,
        transfers,
        models,
        meta,
        operations,
        shares,
        shared,
        share_page,
        docs,
        sign_in,
        audit,
        page,
    ):
        app.register_blueprint(blueprint)
    app.spec_processor(finish_document)  # type: ignore[arg-type]  # it is given a dict
    return app
