"""The scan as links show it: made once in another process, kept with the scan, gone with it."""

import errno
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from helpers import fake_fit

from breastrig.core.errors import FitFailed, NotFound
from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.link_mesh import coloured_mesh, plain_mesh
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.service.service import Service
from breastrig.storage.rows.cuts import put_cuts
from breastrig.storage.storage import Storage
from breastrig.workflow import tasks
from breastrig.workflow.further_jobs import LinkMeshJob
from breastrig.workflow.write_link_mesh import write_link_mesh

VERTICES = np.random.default_rng(5).normal(size=(90, 3))
COLOURED = mesh_glb(VERTICES, np.arange(90).reshape(30, 3), colours=np.full((90, 3), 200, dtype=np.uint8))


@pytest.fixture
def mesh(storage: Storage, scan_id: str) -> Path:
    path = storage.folders.mesh(scan_id)
    path.write_bytes(COLOURED)
    return path


def counted(service: Service, monkeypatch: pytest.MonkeyPatch, before: Callable[[], None] = lambda: None) -> list[int]:
    """One entry for each time that it is made."""
    made, real = [], service._readers.result

    def result(function: object, args: tuple[LinkMeshJob], timeout: float) -> None:
        assert function == tasks.write_link_mesh
        made.append(1)
        before()
        real(function, args, timeout)

    monkeypatch.setattr(service._readers, "result", result)
    return made


def test_it_is_made_once_however_many_ask_and_kept(
    serving, storage: Storage, scan_id: str, mesh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with serving(fake_fit.quick) as service:
        made = counted(service, monkeypatch)
        with ThreadPoolExecutor(8) as pool:
            files = [task.result() for task in [pool.submit(service.link_meshes.get, scan_id) for _ in range(8)]]
        assert len(made) == 1
        assert len({file.etag for file in files}) == 1
        with files[0].open() as file:
            content = file.read()
    assert content == plain_mesh(COLOURED)
    assert "COLOR_0" not in split_glb(content)[0]["meshes"][0]["primitives"][0]["attributes"]
    with serving(fake_fit.quick) as service:
        made = counted(service, monkeypatch)
        assert service.link_meshes.get(scan_id).size == len(content)
        assert made == []
        service.delete_scan(scan_id)
        with pytest.raises(NotFound):
            service.link_meshes.get(scan_id)
    assert list(storage.root.rglob("plain.glb*")) == []


def test_what_was_cut_away_by_hand_is_not_in_it(serving, scan_id: str, mesh: Path) -> None:
    right_half = {
        "to_picture": np.eye(4).T.ravel().tolist(),
        "lasso": [[0.0, -9.0], [9.0, -9.0], [9.0, 9.0], [0.0, 9.0]],
    }
    left = VERTICES.reshape(30, 3, 3)[:, :, 0].mean(axis=1) < 0.0
    with serving(fake_fit.quick) as service:
        whole = service.link_meshes.get(scan_id)
        put_cuts(service.storage, scan_id, (right_half,))
        cut = service.link_meshes.get(scan_id)
        with cut.open() as file:
            content = file.read()
        put_cuts(service.storage, scan_id, ())
        assert service.link_meshes.get(scan_id).etag == whole.etag
        with service.link_meshes.get(scan_id, has_colours=True).open() as file:
            assert file.read() == COLOURED, "nothing is cut: it is the scan's own"
        put_cuts(service.storage, scan_id, (right_half,))
        with service.link_meshes.get(scan_id, has_colours=True).open() as file:
            assert file.read() == coloured_mesh(COLOURED, (right_half,))
        service.delete_scan(scan_id)
        assert [*service.storage.root.rglob("plain*"), *service.storage.root.rglob("coloured*")] == []
    document, binary = split_glb(content)
    arrays, primitive = GltfArrays(document, binary), document["meshes"][0]["primitives"][0]
    points = arrays.read(primitive["attributes"]["POSITION"]) + document["nodes"][0].get("translation", np.zeros(3))
    corners = points[arrays.read(primitive["indices"]).reshape(-1, 3)]
    assert 0 < np.count_nonzero(left) < 30
    np.testing.assert_allclose(corners, VERTICES.reshape(30, 3, 3)[left], atol=1e-6)
    assert len(points) == 3 * np.count_nonzero(left)


def test_it_is_not_made_in_the_servers_own_process(
    serving, scan_id: str, mesh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it takes in memory ends with the process that took it."""
    with serving(fake_fit.quick) as service:
        monkeypatch.setattr("breastrig.workflow.write_link_mesh.plain_mesh", lambda *_given: os._exit(1))
        assert service.link_meshes.get(scan_id).size > 0


def test_a_scan_that_is_deleted_while_it_is_made_leaves_nothing(
    serving, storage: Storage, scan_id: str, mesh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with serving(fake_fit.quick) as service:
        counted(service, monkeypatch, before=lambda: service.delete_scan(scan_id))
        with pytest.raises(NotFound):
            service.link_meshes.get(scan_id)
    assert not storage.folders.scan(scan_id).exists()
    assert list(storage.root.rglob("plain.glb*")) == []


def test_a_full_disk_is_no_broken_process(serving, scan_id: str, mesh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(fake_fit.quick) as service:

        def full(*_args: object) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

        with monkeypatch.context() as disk:
            disk.setattr(service._readers, "result", full)
            with pytest.raises(OSError, match="No space") as refused:
                service.link_meshes.get(scan_id)
        assert refused.value.errno == errno.ENOSPC
        assert service.link_meshes.get(scan_id).size > 0


@pytest.mark.parametrize("broken", [TimeoutError(), RuntimeError("it died"), OSError("it died")])
def test_a_process_that_dies_is_a_sentence_and_the_next_one_tries_again(
    serving, scan_id: str, mesh: Path, monkeypatch: pytest.MonkeyPatch, broken: Exception
) -> None:
    with serving(fake_fit.quick) as service:

        def dies(*_args: object) -> None:
            raise broken

        with monkeypatch.context() as process:
            process.setattr(service._readers, "result", dies)
            with pytest.raises(FitFailed, match=r"try again.*\.$"):
                service.link_meshes.get(scan_id)
        assert service.link_meshes.get(scan_id).size > 0


def test_a_scan_without_a_mesh_or_no_scan_at_all_is_not_found(serving, scan_id: str) -> None:
    with serving(fake_fit.quick) as service:
        for unknown in (scan_id, "nobody"):
            with pytest.raises(NotFound):
                service.link_meshes.get(unknown)


def test_too_little_memory_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mesh.glb").write_bytes(COLOURED)

    def too_large(*_given: object) -> bytes:
        raise MemoryError

    monkeypatch.setattr("breastrig.workflow.write_link_mesh.plain_mesh", too_large)
    with pytest.raises(Exception, match=r"too large to be shown through a link; simplify it first\.$"):
        write_link_mesh(LinkMeshJob(tmp_path / "mesh.glb", tmp_path / "plain.glb"))
    assert not (tmp_path / "plain.glb").exists()
