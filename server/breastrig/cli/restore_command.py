"""`breastrig restore FILE DATA`: a backup into a new data folder, without patients who were deleted since."""

from breastrig.cli.administration.restore import add_options as add_options
from breastrig.cli.administration.restore import run as run
