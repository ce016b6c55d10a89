"""The modules that the fork server imports beforehand are there, and are those that tasks need."""

from importlib.util import find_spec

from breastrig.core.late_function import LateFunction
from breastrig.service import fit_worker
from breastrig.service.task_modules import REMOTE_MODULES, TASK_MODULES
from breastrig.workflow import tasks

LATE = [one for one in vars(tasks).values() if isinstance(one, LateFunction)]


def test_every_named_module_is_there() -> None:
    assert [name for name in (*TASK_MODULES, *REMOTE_MODULES) if find_spec(name) is None] == []


def test_every_task_of_the_service_is_in_a_named_module() -> None:
    assert {fit_worker.execute_fit.__module__, *(one.module for one in LATE)} <= set(TASK_MODULES)


def test_every_late_function_is_there() -> None:
    assert len(LATE) > 10
    assert [one.function.__module__ for one in LATE] == [one.module for one in LATE]
