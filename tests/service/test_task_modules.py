"""The modules that the fork server imports beforehand are there, and are those that tasks need."""

import pickle
from functools import partial
from importlib.util import find_spec
from pkgutil import resolve_name

from breastrig.service.fits import fit_worker
from breastrig.service.task_modules import TASK_MODULES
from breastrig.use import tasks

LATE = {name: each for name, each in vars(tasks).items() if isinstance(each, partial)}


def test_every_named_module_is_there() -> None:
    assert [name for name in TASK_MODULES if find_spec(name) is None] == []


def test_every_task_of_the_service_is_in_a_named_module() -> None:
    modules = {each.args[0].partition(":")[0] for each in LATE.values()}
    assert {fit_worker.execute_fit.__module__, *modules} <= set(TASK_MODULES)


def test_every_task_is_the_function_of_its_name_and_can_be_sent() -> None:
    assert len(LATE) > 10
    for name, each in LATE.items():
        assert callable(resolve_name(each.args[0]))
        assert each.args[0].partition(":")[2] == name
        assert pickle.loads(pickle.dumps(each)).args == each.args
