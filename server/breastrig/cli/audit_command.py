"""`breastrig audit ...`: the audit log of a data folder.

Exit codes: 0 done, 1 the log is not as it was written, 2 bad input or usage.
"""

from breastrig.cli.administration.audit import add_options as add_options
from breastrig.cli.administration.audit import run as run
