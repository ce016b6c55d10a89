"""A process that imports this remembers what it computes, as tasks of services do; see remembered.py.

The fork server imports here once what tasks of lesions and images else import each on its own.
"""

import pydicom  # noqa: F401
import trimesh  # noqa: F401

from helpers.remembered import install

install()
