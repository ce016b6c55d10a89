"""No folder is taken for BreastRig's own that is not, and none that is its own is refused."""

import os
import sqlite3
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from breastrig.cli.main import main
from breastrig.core.errors import BadSettings
from breastrig.execution.limits import FitLimits
from breastrig.index.file import current, fault_of, installation_of
from breastrig.service.service import Service
from breastrig.storage import data_folder
from breastrig.storage.data_folder import Ownership, installation_id, ownership_of
from breastrig.storage.storage import Storage

pytestmark = pytest.mark.long

THEIRS = ("scans/p1", "fits/p1", "cases/p1", "rubbish/p1")

State = dict[str, tuple[int, int, bytes | str | None]]


def state(root: Path) -> State:
    """Everything below, with its times."""
    found = {}
    for path in (root, *root.rglob("*")):
        facts = path.lstat()
        content = os.readlink(path) if path.is_symlink() else path.read_bytes() if path.is_file() else None
        found[str(path)] = (facts.st_mode, facts.st_mtime_ns, content)
    return found


def start(root: Path) -> None:
    """What `breastrig serve` does with its data folder."""
    with Service(Storage(root), fits=FitLimits(workers=1, grace_s=0.1), keep_days=None).started():
        pass


def scans_of_others(root: Path) -> None:
    for place in THEIRS:
        (root / place).mkdir(parents=True)
        (root / place / "a").write_text("x")


def scans_of_others_and_a_lock(root: Path) -> None:
    scans_of_others(root)
    (root / "lock").touch()


def empty_scans_of_others(root: Path) -> None:
    (root / "scans" / "p1").mkdir(parents=True)


def a_file(root: Path) -> None:
    (root / "letter.txt").write_text("x")


def a_file_called_as_the_marker_is(root: Path) -> None:
    (root / "installation").write_text("how to install\n")


def a_folder_called_as_the_marker_is(root: Path) -> None:
    (root / "installation").mkdir()


def a_link_called_as_the_marker_is(root: Path) -> None:
    other = root.with_name("other")
    other.mkdir()
    (other / "installation").write_text("a" * 22)
    (root / "installation").symlink_to(other / "installation")


def a_database_of_others(root: Path) -> None:
    rows = sqlite3.connect(root / "breastrig.sqlite3")
    rows.execute("PRAGMA journal_mode = WAL")
    rows.execute("CREATE TABLE scans (a)")
    rows.close()


def a_file_called_as_the_database_is(root: Path) -> None:
    (root / "breastrig.sqlite3").write_text("no database")


FOREIGN = (
    scans_of_others,
    scans_of_others_and_a_lock,
    empty_scans_of_others,
    a_file,
    a_file_called_as_the_marker_is,
    a_folder_called_as_the_marker_is,
    a_link_called_as_the_marker_is,
    a_database_of_others,
    a_file_called_as_the_database_is,
)


@pytest.mark.parametrize("fill", FOREIGN)
def test_a_folder_of_somebody_elses_is_refused_and_left_as_it_is(
    fill: Callable[[Path], None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = tmp_path / "s"
    root.mkdir()
    fill(root)
    before = state(tmp_path)
    with pytest.raises(BadSettings, match="holds files but is no data folder of BreastRig"):
        start(root)
    assert state(tmp_path) == before
    assert main(["serve", "--port", "0", "--data", str(root)]) == 2
    assert main(["purge", "--all", "--data", str(root)]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2
    assert "so it is left as it is; choose an empty or a new folder with --data." in said[0]
    assert said[1].startswith("breastrig: There is no BreastRig data folder at ")
    assert state(tmp_path) == before


def test_what_others_put_into_our_folder_stays(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    root = tmp_path / "s"
    start(root)
    scans_of_others(root)
    (root / "letter.txt").write_text("x")
    start(root)
    assert main(["purge", "--all", "--data", str(root)]) == 0
    for place in (*THEIRS, "letter.txt"):
        assert (root / place / "a" if place in THEIRS else root / place).read_text() == "x"
    said = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert said == ["1 files or folders among the cases are none of BreastRig's; they stay"] * 2


@pytest.mark.parametrize("place", ["missing/too", "new_disk"])
def test_an_empty_or_missing_folder_becomes_ours_and_the_marker_comes_first(
    place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = tmp_path / place
    (tmp_path / "new_disk" / "lost+found").mkdir(parents=True)

    def write_and_die(root: Path, installation: str) -> None:
        assert set(os.listdir(root)) <= {"lost+found"}
        write(root, installation)
        raise KeyboardInterrupt

    write = data_folder.write_marker
    with monkeypatch.context() as patch:
        patch.setattr(data_folder, "write_marker", write_and_die)
        with pytest.raises(KeyboardInterrupt):
            start(root)
    assert set(os.listdir(root)) - {"lost+found"} == {"installation"}
    before = installation_id(root)
    start(root)
    assert installation_id(root) == before
    file = current(root)
    assert file is not None
    with closing(sqlite3.connect(file)) as rows:
        assert installation_of(rows) == before


def test_a_marker_whose_writing_was_interrupted_is_written_again(tmp_path: Path) -> None:
    (tmp_path / ".breastrig-installation.part").write_text("abc")
    start(tmp_path)
    assert ownership_of(tmp_path) is Ownership.OURS
    assert not (tmp_path / ".breastrig-installation.part").exists()


def test_of_servers_that_start_at_once_on_a_new_folder_one_gives_it_its_id(tmp_path: Path) -> None:
    root, ids, barrier = tmp_path / "new", [f"{k:022}" for k in range(8)], threading.Barrier(8)
    seen = []

    def start_one(mine: str) -> None:
        barrier.wait()
        data_folder.claim(root, lambda: mine)
        seen.append(installation_id(root))

    threads = [threading.Thread(target=start_one, args=(mine,)) for mine in ids]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(seen) == 8
    assert len(set(seen)) == 1
    assert os.listdir(root) == ["installation"]


def test_a_folder_that_becomes_ours_while_it_is_looked_at_is_not_taken_for_foreign(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another server writes its marker between two looks of this one."""
    (tmp_path / data_folder.PART).write_text("1" * 22)

    def others_marker(root: Path) -> str | None:
        found = installation_id(root)
        if found is None:
            os.replace(root / data_folder.PART, root / "installation")
        return found

    monkeypatch.setattr(data_folder, "installation_id", others_marker)
    data_folder.claim(tmp_path, lambda: "2" * 22)
    assert installation_id(tmp_path) == "1" * 22


def named_file(tmp_path: Path) -> Path:
    (tmp_path / "file").write_text("x")
    return tmp_path / "file"


def below_a_file(tmp_path: Path) -> Path:
    return named_file(tmp_path) / "data"


def dangling_link(tmp_path: Path) -> Path:
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    return tmp_path / "link"


def link_to_itself(tmp_path: Path) -> Path:
    (tmp_path / "link").symlink_to(tmp_path / "link")
    return tmp_path / "link"


def long_name(tmp_path: Path) -> Path:
    return tmp_path / ("x" * 300)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (named_file, "{} is a file and no folder; choose a folder with --data."),
        (below_a_file, "The data folder {} cannot be created (Not a directory); choose another with --data."),
        (
            dangling_link,
            "The data folder {} is a link that leads nowhere; mend the link or choose another with --data.",
        ),
        (
            link_to_itself,
            "The data folder {} cannot be read (Too many levels of symbolic links); choose another with --data.",
        ),
        (long_name, "The data folder {} cannot be read (File name too long); choose another with --data."),
    ],
)
def test_what_is_no_folder_is_one_sentence(
    make: Callable[[Path], Path], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = make(tmp_path)
    before = state(tmp_path)
    for command in (["serve", "--port", "0"], ["purge", "--all"]):
        assert main([*command, "--data", str(root)]) == 2
        assert capsys.readouterr().err == f"breastrig: {sentence.format(root)}\n"
    assert state(tmp_path) == before


def test_a_folder_that_cannot_be_written_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The system's refusal is made up, as nothing is refused to the user who runs tests in a container."""

    def refuse(*_args: object, **_more: object) -> None:
        raise PermissionError(13, "Permission denied")

    made = tmp_path / "made"
    start(made)
    with monkeypatch.context() as patch:
        patch.setattr(data_folder, "write_marker", refuse)
        assert main(["serve", "--port", "0", "--data", str(tmp_path / "new")]) == 2
    assert "cannot be written (Permission denied)" in capsys.readouterr().err
    real = os.open
    with monkeypatch.context() as patch:
        patch.setattr(os, "open", lambda path, *more: refuse() if Path(path).name == "lock" else real(path, *more))
        for command in (["serve", "--port", "0"], ["purge", "--all"]):
            assert main([*command, "--data", str(made)]) == 2
            said = capsys.readouterr().err
            assert said.startswith(f"breastrig: The data folder {made} cannot be written (Permission denied); ")
            assert said.count("\n") == 1


def test_a_damaged_index_is_made_again_and_the_log_says_so(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    start(tmp_path)
    file = current(tmp_path)
    assert file is not None
    file.write_bytes(b"no database at all")
    start(tmp_path)
    said = [record.getMessage() for record in caplog.records if record.levelname == "ERROR"]
    assert said == ["the index is damaged; it is made again from the folders"]
    assert fault_of(current(tmp_path), str(installation_id(tmp_path))) is None
    assert not file.exists()


@pytest.mark.parametrize("blank", ["", "\t"])
def test_no_name_is_not_the_current_folder(
    blank: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    scans_of_others(tmp_path)
    before = state(tmp_path)
    for command in (["serve", "--port", "0"], ["purge", "--all"], ["config"]):
        with pytest.raises(SystemExit) as stop:
            main([*command, "--data", blank])
        assert stop.value.code == 2
        assert "is no place; give a path" in capsys.readouterr().err
    settings = tmp_path.parent / f"{tmp_path.name}.toml"
    settings.write_text(f'data = "{blank}"'.replace("\t", "\\t"))
    assert main(["serve", "--port", "0", "--config", str(settings)]) == 2
    assert f"data (file {settings}): " in capsys.readouterr().err
    monkeypatch.setenv("BREASTRIG_DATA", blank)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path.parent / f"{tmp_path.name}-data"))
    assert main(["config"]) == 0
    assert f"{tmp_path.name}-data" in capsys.readouterr().out  # the default
    assert state(tmp_path) == before
