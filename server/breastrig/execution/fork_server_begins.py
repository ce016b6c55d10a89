"""What the fork server imports first, before all that takes long: it stops looking for garbage, and listens.

Nothing of modules is garbage, and looking for it takes an eighth of their import.  Each child looks again, for what it
makes itself (processes.py).
"""

import gc

from breastrig.execution import learned_modules

gc.disable()
learned_modules.listen()
