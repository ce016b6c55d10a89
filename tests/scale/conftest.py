"""A Dask cluster, started once for a file of tests, with services around it.

Each file has its own: what nobody asks anything any more takes a twelfth of a core all the same, to the end of the run.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.installations import Large, two_workers
from helpers.installed_service import Running, serving
from helpers.remembered_uploads import remembering_uploads
from helpers.toy_rig import toy_rig
from helpers.uploads import torso as torso_ply

from breastrig_studies.output.rig_files import write_rig


@pytest.fixture(scope="module", autouse=True)
def no_upload_read_twice() -> Iterator[None]:
    with remembering_uploads():
        yield


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Large]:
    """A Dask scheduler with two workers."""
    with two_workers(tmp_path_factory.mktemp("dask")) as cluster:
        yield Large(cluster)


@pytest.fixture(scope="session")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("model")
    write_rig(toy_rig(), folder)
    return folder / "toy.glb"


@pytest.fixture(scope="session")
def torso() -> bytes:
    return torso_ply()


@pytest.fixture(scope="module")
def running(large: Large, model: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """The service that most tests share."""
    with serving(large, tmp_path_factory.mktemp("dask") / "data", model) as found:
        yield found
