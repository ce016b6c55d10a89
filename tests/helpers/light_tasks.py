"""What processes of tasks import beforehand where all tasks are stand-ins: none of the numerics, which take seconds.

A task that needs more all the same imports it itself, and takes so much longer.
"""

LIGHT_TASK_MODULES = ("breastrig.service.fits.fit_worker", "helpers.fake_fit", "helpers.remembered_uploads")
