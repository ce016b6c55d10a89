"""An archive of others until this is ended: `python serve_archive.py FOLDER`; FOLDER/archives.toml names it.

There, Archive takes STOW-RS and Gone is at an address where nobody listens.
"""

import os
import signal
import sys
import time
from pathlib import Path

from helpers.archives import tiny_archive

signal.signal(signal.SIGTERM, lambda *_: sys.exit())  # the archive is ended with this
folder = Path(sys.argv[1])
with tiny_archive(folder) as archive:
    new = folder / "archives.new"
    new.write_text(f'[Archive]\nstow = "{archive.stow}"\n\n[Gone]\nstow = "http://127.0.0.1:9/dicomweb"\n')
    os.replace(new, folder / "archives.toml")
    parent = os.getppid()
    while os.getppid() == parent:  # whoever has started it is there
        time.sleep(0.2)
