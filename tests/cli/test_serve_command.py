"""What keeps the service from starting is one sentence, what stops it does so at any time, its secrets stay its own."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from queue import Queue

import httpx
import pytest
from helpers.real_server import server
from helpers.toy_rig import toy_rig
from helpers.waiting import PATIENCE_S

from breastrig.cli import interruption, serve_command
from breastrig.cli.main import main
from breastrig.cli.serve_command import _stop_on_signals
from breastrig.service.events.feeds import Notifier
from breastrig_studies.output.rig_files import write_rig

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("model")
    write_rig(toy_rig(), folder)
    return folder / "toy.glb"


@pytest.mark.slow
def test_it_makes_a_token_and_prints_the_address_that_lets_a_browser_in(tmp_path: Path, model: Path) -> None:
    with server(tmp_path / "data", model, tmp_path / "log", FAKE_TOKEN="made") as (process, printed):
        address, _, token = printed.partition("?token=")
        assert process.stdout is not None
        assert process.stdout.readline().startswith("This address lets a browser in;")
        assert httpx.get(f"{address}api/patients", timeout=PATIENCE_S).status_code == 401
        bearer = {"Authorization": f"Bearer {token}"}
        assert httpx.get(f"{address}api/patients", headers=bearer, timeout=PATIENCE_S).status_code == 200
        with httpx.Client(timeout=PATIENCE_S) as browser:
            assert browser.get(printed).headers["Location"] == "/"
            assert browser.get(f"{address}api/patients").status_code == 200
            [cookie] = browser.cookies
            assert cookie == f"breastrig_session_{address.rstrip('/').rpartition(':')[2]}"
    assert token not in (tmp_path / "log").read_text()


def test_a_browser_is_opened_by_a_file_of_this_user_alone_and_no_command_names_the_token(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    opened: Queue[str] = Queue()
    monkeypatch.setattr(serve_command.webbrowser, "open", opened.put)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    with ExitStack() as stack:
        serve_command._show("http://127.0.0.1:1/?token=x", stack)
        monkeypatch.setenv("DISPLAY", ":0")
        serve_command._show("http://127.0.0.1:1/?token=secret&more", stack)
        address = opened.get(timeout=PATIENCE_S)
        assert "secret" not in address
        page = Path(address.removeprefix("file://"))
        assert "url=http://127.0.0.1:1/?token=secret&amp;more" in page.read_text()
        assert page.parent.stat().st_mode & 0o077 == 0
    assert opened.empty()
    assert not page.parent.exists()


@pytest.mark.slow
def test_a_service_that_is_stopped_while_it_starts_says_so_and_ends(tmp_path: Path, model: Path) -> None:
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
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=PATIENCE_S) in (130, -signal.SIGINT)
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
    def interrupted(_notifier: Notifier) -> None:
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)

    interruption.watch()
    monkeypatch.setattr(Notifier, "start", interrupted)
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
