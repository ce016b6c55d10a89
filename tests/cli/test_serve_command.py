"""What keeps the service from starting is one sentence, what stops it does so at any time, its secrets stay its own."""

import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import httpx
import pytest
from helpers.real_server import children, server
from helpers.toy_rig import toy_rig

from breastrig.cli.main import main
from breastrig.cli.serve_command import _Stop
from breastrig.gltf.write_rig import write_rig


@pytest.mark.parametrize(
    ("option", "value", "sentence"),
    [
        ("--database", "postgresql://me:geheim@127.0.0.1:1/rig", "The database cannot be reached ("),
        ("--files", "nosuch://bucket", "Files cannot be kept at nosuch://bucket ("),
    ],
)
def test_a_place_that_cannot_be_used_is_named(
    option: str, value: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["serve", "--port", "0", "--data", str(tmp_path / "data"), option, value]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"breastrig: {sentence}")
    assert said.count("\n") == 1
    assert "geheim" not in said


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("model")
    write_rig(toy_rig(), folder)
    return folder / "toy.glb"


def test_no_process_of_the_service_inherits_its_secrets(tmp_path: Path, model: Path) -> None:
    token = "a-token-of-more-than-sixteen-characters"
    with server(tmp_path / "data", model, tmp_path / "log", BREASTRIG_TOKEN=token) as (process, address):
        assert httpx.get(f"{address}api/meta").status_code == 401
        assert httpx.get(f"{address}api/meta", headers={"Authorization": f"Bearer {token}"}).status_code == 200
        below = children(process.pid)
        environments = [Path(f"/proc/{pid}/environ").read_bytes() for pid in below]
    assert len(environments) > 2  # a fork server, and processes for scans and fits
    assert all(b"PATH=" in environment for environment in environments)
    assert not any(token.encode() in environment for environment in environments)


@pytest.mark.parametrize(("number", "codes"), [(signal.SIGINT, {130, -signal.SIGINT}), (signal.SIGTERM, {0})])
def test_a_service_that_is_stopped_while_it_starts_says_so_and_ends(
    number: signal.Signals, codes: set[int], tmp_path: Path, model: Path
) -> None:
    """Python dies of SIGINT itself, after all is tidied up, when that met it in a piece of code made at run time."""
    command = [sys.executable, "-m", "breastrig.cli.main", "serve", "--port", "0", "--model", str(model)]
    errors = tmp_path / "errors"
    with (
        errors.open("w") as file,
        subprocess.Popen([*command, "--data", str(tmp_path / "data")], stdout=subprocess.PIPE, stderr=file) as process,
    ):
        while not (tmp_path / "data").exists():  # its lock comes next, long before the service is ready
            assert process.poll() is None, errors.read_text()
            time.sleep(0.01)
        process.send_signal(number)
        assert process.wait(timeout=60) in codes
        assert process.stdout is not None
        assert process.stdout.read() == b""  # and no child is left that could write
    said = [line for line in errors.read_text().splitlines() if not line.startswith("{")]
    assert said == (["breastrig: stopped."] if number == signal.SIGINT else [])


def test_a_signal_that_python_swallows_still_stops_the_service() -> None:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    ended: list[bool] = []
    try:
        stop = _Stop()
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        assert not ended
        stop.when_serving(lambda: ended.append(True))
        assert ended == [True]
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        assert ended == [True, True]  # the second does not disturb
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
