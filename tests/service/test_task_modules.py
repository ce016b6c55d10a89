"""The modules that the fork server imports beforehand are there, and are those that tasks need."""

import subprocess
import sys
from importlib.util import find_spec

from breastrig.service.task_modules import TASK_MODULES

LATE = """
import importlib, sys
for name in sys.argv[1:]:
    importlib.import_module(name)
before = {*sys.modules}
import breastrig.service.service  # imports the functions that it has executed in other processes
print(*sorted(name for name in sys.modules.keys() - before if name.startswith("breastrig.use.")))
"""


def test_every_named_module_is_there() -> None:
    assert [name for name in TASK_MODULES if find_spec(name) is None] == []


def test_every_use_case_of_the_service_is_imported_with_the_named_modules() -> None:
    late = subprocess.run([sys.executable, "-c", LATE, *TASK_MODULES], capture_output=True, check=True, text=True)
    assert late.stdout.split() == []
