"""Archives for tests: one of others (tiny-pacs) as a process, and pynetdicom's own, which answers as a test asks."""

import socket
import ssl
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pydicom.dataset import Dataset
from pydicom.uid import UID
from pynetdicom import AE, evt

from helpers.nginx import free_port
from helpers.waiting import until

CONFIGURATION = """
ae: {{ae_title: ARCHIVE, port: {dicom}, dump_ds: false}}
components:
  InMemoryStorage: {{on: false}}
  FileStorage: {{on: true, storage_dir: {files}, overwrite: true}}
  HttpServer: {{on: true, host: 127.0.0.1, port: {web}}}
  DICOMWeb: {{on: true, prefix: /dicomweb}}
"""


@dataclass(frozen=True)
class Archive:
    """Where it listens, and the folder of what it has stored."""

    dicom: str
    stow: str
    files: Path


@contextmanager
def tiny_archive(folder: Path) -> Iterator[Archive]:
    """Ready for C-STORE and STOW-RS; it takes no STL by C-STORE."""
    dicom, web, files = free_port(), free_port(), folder / "files"
    files.mkdir(parents=True)
    (folder / "archive.yaml").write_text(CONFIGURATION.format(dicom=dicom, web=web, files=files))
    command = [sys.executable, "-m", "tiny_pacs", "run", "-c", str(folder / "archive.yaml")]
    with (folder / "log").open("w") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, cwd=folder)
    try:
        until(lambda: process.poll() is not None or all(map(_listens, (dicom, web))), "the archive")
        assert process.poll() is None, (folder / "log").read_text()
        yield Archive(f"ARCHIVE@127.0.0.1:{dicom}", f"http://127.0.0.1:{web}/dicomweb", files)
    finally:
        process.kill()
        process.wait()


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@contextmanager
def answering(
    classes: set[UID], answer: Callable[[Dataset], int], secured: ssl.SSLContext | None = None, calling: str = ""
) -> Iterator[int]:
    """The port of a storage node STORE whose status of each object is `answer`'s."""
    entity = AE("STORE")
    entity.require_called_aet = True
    entity.require_calling_aet = [calling] if calling else []
    for each in classes:
        entity.add_supported_context(each)
    handlers = [(evt.EVT_C_STORE, lambda event: answer(event.dataset))]
    server = entity.start_server(("127.0.0.1", 0), block=False, evt_handlers=handlers, ssl_context=secured)
    assert server is not None
    try:
        yield server.socket.getsockname()[1]
    finally:
        server.shutdown()
