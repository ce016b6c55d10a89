"""What keeps the service from starting is one sentence, what stops it does so at any time, its secrets stay its own."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import httpx
import pytest
from helpers.real_server import children, server
from helpers.toy_rig import toy_rig

from breastrig.cli import interruption, serve_command
from breastrig.cli.main import main
from breastrig.cli.serve_command import _stop_on_signals
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


@pytest.mark.parametrize(("number", "codes"), [(signal.SIGINT, {130, -signal.SIGINT}), (signal.SIGTERM, {143})])
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
        try:
            while not (tmp_path / "data").exists():  # its lock comes next, long before the service is ready
                assert process.poll() is None, errors.read_text()
                time.sleep(0.01)
            process.send_signal(number)
            assert process.wait(timeout=60) in codes
        finally:
            process.kill()
        assert process.stdout is not None
        assert process.stdout.read() == b""  # and no child is left that could write
    said = [line for line in errors.read_text().splitlines() if not line.startswith("{")]
    assert said == ["breastrig: stopped."]


@pytest.fixture
def handlers() -> Iterator[None]:
    """Puts back what the tests' own process does on signals."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    interruption.watch()  # forgets that a signal came
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("handlers")
def test_a_signal_that_python_swallows_while_the_service_starts_still_stops_it(
    tmp_path: Path, model: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> None:
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)

    interruption.watch()
    monkeypatch.setattr(serve_command, "start_fork_server", interrupted)
    assert main(["serve", "--port", "0", "--data", str(tmp_path / "data"), "--model", str(model)]) == 143
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.endswith("breastrig: stopped.\n")


@pytest.mark.usefixtures("handlers")
def test_the_first_signal_ends_the_service_and_a_second_does_not_disturb() -> None:
    ended: list[bool] = []
    _stop_on_signals(lambda: ended.append(True))
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT):
        signal.raise_signal(number)
    assert ended == [True]


@pytest.mark.usefixtures("handlers")
def test_a_signal_that_was_ignored_stays_ignored() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _stop_on_signals(lambda: None)
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    assert signal.getsignal(signal.SIGTERM) not in (signal.SIG_IGN, signal.SIG_DFL)
