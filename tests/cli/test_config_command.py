"""The settings of the service: which one wins, where each came from, and a token that nobody sees."""

from pathlib import Path

import pytest

from breastrig.api.settings import SETTINGS, effective_settings, settings_file, token_source
from breastrig.cli.main import main
from breastrig.core.errors import BadSettings

TOKEN = "a secret of twenty-nine letters"


@pytest.fixture(autouse=True)
def bare(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No setting of the machine that runs the tests."""
    for name in (*SETTINGS, "token", "config"):
        monkeypatch.delenv(f"BREASTRIG_{name.upper()}", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "none"))


def lines(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, tuple[str, str]]:
    """name -> (value, source) as the command prints them."""
    assert main(["config", *arguments]) == 0
    rows = [line.split("  ") for line in capsys.readouterr().out.splitlines()]
    cells = [[cell.strip() for cell in row if cell.strip()] for row in rows]
    return {name: (value, source) for name, value, source in cells}


def test_without_any_setting_all_are_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    found = lines(capsys)
    assert set(found) == {*SETTINGS, "token"}
    assert {source for _, source in found.values()} == {"default"}
    assert (found["host"][0], found["port"][0], found["keep_days"][0]) == ("127.0.0.1", "8321", "30")
    assert found["log_requests"][0] == "auto"


def test_options_win_over_the_environment_and_that_over_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "settings.toml"
    file.write_text('port = 1111\nkeep_days = "forever"\nworkers = 3\nlog = "json"\n')
    monkeypatch.setenv("BREASTRIG_PORT", "2222")
    monkeypatch.setenv("BREASTRIG_WORKERS", "4")
    found = lines(capsys, "--config", str(file), "--port", "3333")
    assert found["port"] == ("3333", "option --port")
    assert found["workers"] == ("4", "environment BREASTRIG_WORKERS")
    assert found["keep_days"] == ("forever", f"file {file}")
    assert found["log"] == ("json", f"file {file}")
    assert found["host"][1] == "default"
    monkeypatch.setenv("BREASTRIG_CONFIG", str(file))
    assert lines(capsys)["log"] == ("json", f"file {file}")


def test_the_users_own_file_is_found(tmp_path: Path) -> None:
    own = tmp_path / "breastrig" / "config.toml"
    assert settings_file(None, {"XDG_CONFIG_HOME": str(tmp_path)}) is None
    own.parent.mkdir()
    own.write_text("")
    assert settings_file(None, {"XDG_CONFIG_HOME": str(tmp_path)}) == own
    assert settings_file(Path("other"), {"XDG_CONFIG_HOME": str(tmp_path)}) == Path("other")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("prot = 1", '"prot" is not a setting; known are: host, port'),
        ("port = 70000", "70000 is not a port"),
        ("keep_days = 0", "would delete each scan at once"),
        ("workers = true", "True is not a count"),
        ('log = "loud"', "use one of auto, text, json"),
        ('token = "x"', "The token does not belong into"),
        ("port", "is not TOML"),
    ],
)
def test_a_file_that_cannot_be_meant_is_refused(tmp_path: Path, capsys, text: str, sentence: str) -> None:
    file = tmp_path / "settings.toml"
    file.write_text(text)
    assert main(["config", "--config", str(file)]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert len(error.splitlines()) == 1
    assert main(["config", "--config", str(tmp_path / "missing.toml")]) == 2


def test_the_token_is_found_and_never_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "token"
    file.write_text(f"{TOKEN}\n")
    assert token_source(effective_settings({"token_file": str(file)}, None, {}), {}) == (TOKEN, f"file {file}")
    variables = {"BREASTRIG_TOKEN": f" {TOKEN}2 ", "BREASTRIG_TOKEN_FILE": str(file)}
    in_environment = effective_settings({}, None, variables)
    assert token_source(in_environment, variables) == (f"{TOKEN}2", "environment BREASTRIG_TOKEN")
    by_option = effective_settings({"token_file": str(file)}, None, variables)
    assert token_source(by_option, variables) == (TOKEN, f"file {file}")
    monkeypatch.setenv("BREASTRIG_TOKEN_FILE", str(file))
    assert lines(capsys)["token"] == ("set, not shown", f"file {file}")
    monkeypatch.setenv("BREASTRIG_TOKEN", TOKEN)
    main(["config"])
    assert TOKEN not in "".join(capsys.readouterr())


@pytest.mark.parametrize("content", [None, "", "  \n", b"\xff\xfe"])
def test_a_token_file_without_a_token_is_refused(tmp_path: Path, content: str | bytes | None) -> None:
    file = tmp_path / "token"
    if content is not None:
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(BadSettings, match="token file"):
        token_source(effective_settings({"token_file": str(file)}, None, {}), {})


def test_purge_looks_where_serve_would(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setenv("BREASTRIG_DATA", str(tmp_path / "elsewhere"))
    assert main(["purge", "--all"]) == 2
    assert f"no BreastRig data folder at {tmp_path / 'elsewhere'}" in capsys.readouterr().err


def test_who_works_can_be_set(capsys: pytest.CaptureFixture[str]) -> None:
    found = lines(capsys, "--scheduler", "tcp://host:8786")
    assert found["scheduler"] == ("tcp://host:8786", "option --scheduler")
    found = lines(capsys)
    assert found["scheduler"][0] == "none: local processes"


@pytest.mark.parametrize(
    ("option", "value", "sentence"),
    [
        ("--scheduler", "host", "is no address of a scheduler"),
    ],
)
def test_an_address_that_is_none_is_a_mistake_of_usage(
    option: str, value: str, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["config", option, value])
    assert stop.value.code == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert "geheim" not in said
