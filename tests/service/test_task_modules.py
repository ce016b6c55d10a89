"""The modules that the fork server imports beforehand are there, and are those that tasks need."""

from importlib.util import find_spec

from breastrig.service import fit_worker, service
from breastrig.service.reports import MAKERS
from breastrig.service.task_modules import REMOTE_MODULES, TASK_MODULES


def test_every_named_module_is_there() -> None:
    assert [name for name in (*TASK_MODULES, *REMOTE_MODULES) if find_spec(name) is None] == []


def test_every_task_of_the_service_is_in_a_named_module() -> None:
    tasks = (
        fit_worker.execute_fit,
        service.run_fit,
        service.run_pair,
        service.read_upload,
        service.propose_on_file,
        service.transfer,
        *MAKERS.values(),
    )
    assert {task.__module__ for task in tasks} <= set(TASK_MODULES)
