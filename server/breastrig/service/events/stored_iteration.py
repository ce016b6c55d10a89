"""One iteration of a fit, as it was stored."""

import json

from breastrig.core.errors import NotFound
from breastrig.storage.rows.events import events_of_kind
from breastrig.storage.rows.fits import FitRow
from breastrig.storage.storage import Storage
from breastrig.workflow.events import Iterated

MOST = 2**31  # a larger number is no offset for every database


def stored_iteration(storage: Storage, fit: FitRow, iteration: int) -> Iterated:
    """Raises NotFound when the fit has no such iteration, or not yet."""
    found = events_of_kind(storage, fit.id, "iterated", offset=iteration) if iteration < MOST else []
    event = Iterated.model_validate(json.loads(found[0].json)) if found else None
    if event is None or event.iteration != iteration:
        raise NotFound(f"This fit has no iteration {iteration}; it has {fit.iterations} so far, from 0.")
    return event
