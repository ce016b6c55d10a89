"""`breastrig backup FILE DATA`: a data folder in one encrypted file (age), also while a server serves it."""

from breastrig.cli.administration.backup import add_options as add_options
from breastrig.cli.administration.backup import run as run
