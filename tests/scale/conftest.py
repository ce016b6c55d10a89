"""The two installations, each started once for a file of tests, with services around them.

Each file has its own: what nobody asks anything any more takes a twelfth of a core all the same, to the end of the run.
"""

import logging
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.installations import Installation, Large, Small, make_bucket, s3_stand_in, two_workers
from helpers.installed_service import Running, serving
from helpers.postgres_server import PostgresServer, postgres_server
from helpers.remembered_uploads import remembering_uploads
from helpers.toy_rig import toy_rig
from helpers.uploads import torso as torso_ply

from breastrig.gltf.write_rig import write_rig


@pytest.fixture(scope="module", autouse=True)
def no_upload_read_twice() -> Iterator[None]:
    with remembering_uploads():
        yield


@pytest.fixture(scope="module")
def postgres() -> Iterator[PostgresServer]:
    with postgres_server() as server:
        yield server


@pytest.fixture(scope="module")
def large(postgres: PostgresServer, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Large]:
    """PostgreSQL, the S3 stand-in with its bucket, a Dask scheduler with two workers."""
    logging.getLogger("werkzeug").setLevel(logging.ERROR)  # the stand-in tells of each request
    with ExitStack() as stack:
        environment = stack.enter_context(s3_stand_in())
        patch = stack.enter_context(pytest.MonkeyPatch.context())
        for name, value in environment.items():
            patch.setenv(name, value)
        make_bucket()
        yield Large(postgres, stack.enter_context(two_workers(tmp_path_factory.mktemp("dask"), environment)))


@pytest.fixture(scope="module", params=["sqlite_disk_local", "postgres_s3_dask"])
def installation(request: pytest.FixtureRequest) -> Installation:
    return Small() if request.param == "sqlite_disk_local" else request.getfixturevalue("large")


@pytest.fixture(scope="session")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("model")
    write_rig(toy_rig(), folder)
    return folder / "toy.glb"


@pytest.fixture(scope="session")
def torso() -> bytes:
    return torso_ply()


@pytest.fixture(scope="module")
def running(installation: Installation, model: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """The service that most tests share."""
    location = installation.location(tmp_path_factory.mktemp(installation.name))
    with serving(installation, location, model) as found:
        yield found
