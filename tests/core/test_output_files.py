"""Results never replace an input or what somebody else made, are whole or absent, and are for their owner only."""

import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from breastrig.core.errors import BadInput
from breastrig.core.output_files import Output, OutputSet, all_or_nothing, check_output, single_file
from breastrig.core.private_files import is_ordinary, read_ordinary, shown, write_private

NAMES = ("scan.ply", "drawing.json", "result.json")
FIT = OutputSet(Path(), NAMES, "result.json", "breastrig/result@1")


@pytest.fixture(autouse=True, params=[0o000, 0o022, 0o277])
def umask(request: pytest.FixtureRequest) -> Iterator[None]:
    """Whatever the user's is."""
    before = os.umask(request.param)
    yield
    os.umask(before)


def output(folder: Path, *inputs: Path, force: bool = False) -> Output:
    return Output(folder, (FIT,), inputs, force)


def write(output: Output, word: str = "first") -> None:
    with all_or_nothing(output) as out:
        for name in NAMES:
            content = {"schema": "breastrig/result@1", "word": word} if name.endswith(".json") else word
            (out / name).write_text(json.dumps(content))


def contents(folder: Path) -> dict[str, str]:
    return {file.name: file.read_text() for file in folder.iterdir() if file.is_file()}


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_folders_and_files_are_for_their_owner_only_whatever_the_umask(tmp_path: Path) -> None:
    write(output(tmp_path / "a" / "b"))
    assert [mode(tmp_path / each) for each in ("a", "a/b")] == [0o700, 0o700]
    assert {mode(file) for file in (tmp_path / "a" / "b").iterdir()} == {0o600}
    assert set(contents(tmp_path / "a" / "b")) == set(NAMES)  # and nothing beside


def test_a_folder_that_was_there_keeps_its_mode(tmp_path: Path) -> None:
    tmp_path.chmod(0o755)
    write(output(tmp_path))
    assert mode(tmp_path) == 0o755
    assert {mode(tmp_path / name) for name in NAMES} == {0o600}


def test_what_an_earlier_run_wrote_is_replaced_and_made_private(tmp_path: Path) -> None:
    write(output(tmp_path))
    (tmp_path / "scan.ply").chmod(0o644)
    write(output(tmp_path), "second")
    assert json.loads((tmp_path / "scan.ply").read_text()) == "second"
    assert mode(tmp_path / "scan.ply") == 0o600


def test_what_is_no_earlier_result_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "drawing.json").write_text('{"schema": "breastrig/drawing@1", "mine": true}')
    (tmp_path / "result.json").write_text('{"schema": "somebody/else@1"}')
    before = contents(tmp_path)
    with pytest.raises(BadInput, match=r"holds drawing\.json, result\.json already; .*--force"):
        write(output(tmp_path), "second")
    assert contents(tmp_path) == before
    write(output(tmp_path, force=True), "second")
    assert "second" in contents(tmp_path)["drawing.json"]


@pytest.mark.parametrize("link", ["symbolic", "hard", "same"])
@pytest.mark.parametrize("force", [False, True])
def test_an_input_is_never_replaced_under_whatever_name(link: str, force: bool, tmp_path: Path) -> None:
    scan = tmp_path / ("scan.ply" if link == "same" else "mine.ply")
    scan.write_text("the patient")
    if link == "symbolic":
        (tmp_path / "scan.ply").symlink_to("mine.ply")
    elif link == "hard":
        (tmp_path / "scan.ply").hardlink_to(scan)
    with pytest.raises(BadInput, match="which this command reads"):
        write(output(tmp_path / ".." / tmp_path.name, scan, force=force))
    assert scan.read_text() == "the patient"
    assert not (tmp_path / "result.json").exists()


def test_a_run_that_fails_or_is_stopped_leaves_the_earlier_results_and_nothing_else(tmp_path: Path) -> None:
    write(output(tmp_path / "out"))
    before = contents(tmp_path / "out")

    def stop() -> None:
        raise KeyboardInterrupt

    def failing(output: Output) -> None:
        with all_or_nothing(output) as out:
            (out / "result.json").write_text("half")
            raise OSError("disk")

    with pytest.raises(OSError, match="disk"):
        failing(output(tmp_path / "out"))
    with pytest.raises(KeyboardInterrupt):
        write(Output(tmp_path / "out", (FIT,), (), stopped=stop), "second")
    assert contents(tmp_path / "out") == before
    assert set(os.listdir(tmp_path / "out")) == set(NAMES)
    with pytest.raises(KeyboardInterrupt), all_or_nothing(output(tmp_path / "new" / "deep")):
        raise KeyboardInterrupt
    assert not (tmp_path / "new").exists()  # folders that were made for nothing


def test_if_one_file_cannot_be_put_in_place_none_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(output(tmp_path))
    before = contents(tmp_path)
    replace = os.replace

    def failing(source: Path, goal: Path) -> None:
        if Path(goal) == tmp_path / "result.json" and Path(source).parent.name == "new":
            raise OSError(5, "Input/output error")
        replace(source, goal)

    monkeypatch.setattr("breastrig.core.output_files.os.replace", failing)
    with pytest.raises(BadInput, match="cannot be written"):
        write(output(tmp_path), "second")
    assert contents(tmp_path) == before
    assert set(os.listdir(tmp_path)) == set(NAMES)


def test_what_came_while_the_command_ran_is_not_replaced(tmp_path: Path) -> None:
    def run() -> None:
        with all_or_nothing(output(tmp_path)) as out:
            (out / "result.json").write_text("{}")
            (tmp_path / "result.json").write_text("mine")

    with pytest.raises(BadInput, match="already"):
        run()
    assert contents(tmp_path) == {"result.json": "mine"}


def test_halves_of_a_killed_run_are_removed_and_those_of_a_running_one_stay(tmp_path: Path) -> None:
    half = tmp_path / ".breastrig-part-abcdefgh"
    half.mkdir(mode=0o700)
    old, new = tmp_path / ".breastrig-file-old", tmp_path / ".breastrig-file-new"
    for file in (old, new):
        file.write_bytes(b"scan")
    os.utime(old, (0.0, 0.0))
    with all_or_nothing(output(tmp_path)) as running:
        assert not half.exists()
        assert (old.exists(), new.exists()) == (False, True)
        with all_or_nothing(single_file(tmp_path / "other.json", (), False)) as out:
            (out / "other.json").write_text("{}")
        assert running.is_dir()
        (running / "result.json").write_text("{}")
    assert (tmp_path / "result.json").is_file()


def test_one_file_that_is_there_needs_force(tmp_path: Path) -> None:
    (tmp_path / "there.json").write_text('{"points": [1.5, 2]}')
    with pytest.raises(BadInput, match=r"there\.json already"):
        check_output(single_file(tmp_path / "there.json", (), False))
    check_output(single_file(tmp_path / "there.json", (), True))


def test_a_set_of_varying_names_drops_what_does_not_come_again_and_nothing_else(tmp_path: Path) -> None:
    def run(*names: str, taken: tuple[str, ...] = ()) -> None:
        page = OutputSet(Path(), ("page.json", *taken), "page.json", "a/page@1", varying=True)
        with all_or_nothing(Output(tmp_path, (page,), ())) as out:
            (out / "figures").mkdir(mode=0o700)
            for name in names:
                (out / name).write_text(name)
            (out / "page.json").write_text('{"schema": "a/page@1"}')

    (tmp_path / "mine.csv").write_text("mine")
    run("a.csv", "figures/b.png")
    run("a.csv")
    assert set(contents(tmp_path)) == {"mine.csv", "a.csv", "page.json"}
    assert not (tmp_path / "figures" / "b.png").exists()
    (tmp_path / "page.json").unlink()
    with pytest.raises(BadInput, match=r"mine\.csv"):
        run("mine.csv", taken=("mine.csv",))
    assert (tmp_path / "mine.csv").read_text() == "mine"


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("file/out", "is no folder"),
        ("n" * 300, "too long a name"),
        ("/".join(["n" * 200] * 30), "cannot be written"),
        ("loop/out", "is no folder|cannot be written"),
    ],
)
def test_a_place_that_cannot_be_is_one_short_sentence(place: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(BadInput, match=words) as error:
        write(output(tmp_path / place))
    assert len(str(error.value)) < 600


def test_a_folder_pipe_or_device_in_the_place_of_a_file_is_refused_even_with_force(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "scan.ply", 0o600)
    with pytest.raises(BadInput, match="no ordinary file"):
        check_output(output(tmp_path, force=True))
    with pytest.raises(BadInput, match="no ordinary file"):
        check_output(single_file(Path("/dev/null"), (), True))
    with pytest.raises(BadInput, match="no name of a file"):
        single_file(Path(), (), False)


def test_reading_does_not_wait_for_a_pipe_nor_read_a_device_to_its_end(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe", 0o600)
    for file in (tmp_path / "pipe", Path("/dev/zero"), tmp_path):
        assert not is_ordinary(file)
        with pytest.raises(OSError, match=r"ordinary|directory"):
            read_ordinary(file, 100)
    write_private(tmp_path / "file", b"12345")
    assert read_ordinary(tmp_path / "file", 3) == b"1234"  # one more than the limit, so that it shows
    assert not is_ordinary(Path("n" * 5000))
    assert len(shown(Path("n" * 5000))) < 200
