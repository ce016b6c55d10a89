"""What the fork server imports before any task: named, not imported, as a cluster's worker needs it in its children."""

from breastrig.workflow.tasks import MODULES

TASK_MODULES = ("breastrig.service.fits.fit_worker", *MODULES, "scipy.interpolate")  # which reports need
