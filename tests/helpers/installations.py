"""The two ways to run the service: everything on one machine, or rows, files and fits each somewhere else."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from breastrig.execution.executor import Executor
from breastrig.storage.location import Location
from helpers.dask_cluster import Cluster, scheduler, wait_until_ready
from helpers.on_disk import bytes_below
from helpers.postgres_server import PostgresServer

BUCKET = "breastrig"
MEMORY_BYTES = 6 * 2**30


class Installation(Protocol):
    name: str

    def location(self, folder: Path) -> Location:
        """A new, empty place."""

    def executor(self) -> Executor | None:
        """Who carries out fits; None: processes of the service's own."""

    def kept(self, location: Location) -> bytes:
        """Everything that is kept there, names and contents."""


class Small:
    """SQLite, the disk, local processes."""

    name = "sqlite_disk_local"

    def location(self, folder: Path) -> Location:
        return Location(folder / "data")

    def executor(self) -> Executor | None:
        return None

    def kept(self, location: Location) -> bytes:
        return _names(location.root) + bytes_below(location.root)


@dataclass(frozen=True)
class Large:
    """PostgreSQL, S3, a Dask cluster."""

    postgres: PostgresServer
    cluster: Cluster
    name = "postgres_s3_dask"

    def location(self, folder: Path) -> Location:
        return Location(folder / "data", self.postgres.new_database(), f"s3://{BUCKET}/{secrets.token_hex(4)}")

    def executor(self) -> Executor:
        from breastrig.execution.dask_pool import DaskPool

        return DaskPool(self.cluster.address, memory_bytes=MEMORY_BYTES)

    def kept(self, location: Location) -> bytes:
        return _names(location.root) + _rows(str(location.database)) + _objects(str(location.files))


def _names(root: Path) -> bytes:
    return " ".join(path.as_posix() for path in root.rglob("*")).encode()


def _rows(url: str) -> bytes:
    """Every row of every table, as text."""
    import psycopg

    with psycopg.connect(url) as connection:
        tables = connection.execute("SELECT tablename FROM pg_tables WHERE schemaname = 'public'").fetchall()
        rows = [row for (table,) in tables for row in connection.execute(f"SELECT t::text FROM {table} t").fetchall()]
    return "\n".join(row[0] for row in rows).encode()


def _objects(url: str) -> bytes:
    """Every object of the bucket below the prefix, and its name."""
    import boto3

    prefix = url.removeprefix(f"s3://{BUCKET}/")
    bucket = boto3.resource("s3").Bucket(BUCKET)
    objects = bucket.objects.filter(Prefix=prefix)
    return b"\n".join(one.key.encode() + b" " + one.get()["Body"].read() for one in objects)


@contextmanager
def s3_stand_in() -> Iterator[dict[str, str]]:
    """A server that speaks S3, with an empty bucket; the environment with which programs find it."""
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        host, port = server.get_host_and_port()
        yield {
            "AWS_ENDPOINT_URL": f"http://{host}:{port}",
            "AWS_ACCESS_KEY_ID": "nobody",
            "AWS_SECRET_ACCESS_KEY": "nothing",
            "AWS_DEFAULT_REGION": "us-east-1",
            "AWS_EC2_METADATA_DISABLED": "true",
            "AWS_CONFIG_FILE": os.devnull,
            "AWS_SHARED_CREDENTIALS_FILE": os.devnull,
        }
    finally:
        server.stop()


@contextmanager
def two_workers(folder: Path, environment: dict[str, str]) -> Iterator[Cluster]:
    """A Dask scheduler with two workers, which find the S3 stand-in."""
    with scheduler(folder) as found:
        for worker in [found.start_worker(1, **environment) for _ in range(2)]:
            wait_until_ready(worker)
        yield found


def make_bucket() -> Any:
    import boto3

    return boto3.client("s3").create_bucket(Bucket=BUCKET)
