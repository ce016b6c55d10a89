"""Names of modules that the fork server imports before any task; a cluster's worker needs them in its children."""

from breastrig.use.tasks import MODULES

TASK_MODULES = ("breastrig.service.fits.fit_worker", *MODULES, "scipy.interpolate")  # which reports need
