"""The modules that the fork server imports beforehand are there, and are those that tasks need."""

import ast
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from breastrig.service import fit_worker
from breastrig.service.task_modules import REMOTE_MODULES, TASK_MODULES
from breastrig.workflow import tasks

LATE = {
    function.name: each
    for function in ast.parse(Path(tasks.__file__).read_text()).body
    if isinstance(function, ast.FunctionDef)
    for each in function.body
    if isinstance(each, ast.ImportFrom)
}


def test_every_named_module_is_there() -> None:
    assert [name for name in (*TASK_MODULES, *REMOTE_MODULES) if find_spec(name) is None] == []


def test_every_task_of_the_service_is_in_a_named_module() -> None:
    assert {fit_worker.execute_fit.__module__, *(each.module for each in LATE.values())} <= set(TASK_MODULES)


def test_every_task_imports_the_function_of_its_name() -> None:
    assert len(LATE) > 10
    for name, each in LATE.items():
        assert [one.name for one in each.names] == [name]
        assert callable(getattr(import_module(str(each.module)), name))
