"""Only what a command needs is imported, and every command is known by its name."""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.example_fit import EXAMPLE

from breastrig.cli.main import COMMANDS, main, parser

HEAVY = {"numpy", "scipy", "pydantic", "trimesh", "igl", "PIL", "tqdm", "flask", "sqlite3"}


def imported_by(*words: str) -> set[str]:
    code = "import contextlib, sys\nfrom breastrig.cli.main import main\nwith contextlib.suppress(SystemExit):\n"
    code += f"    main({list(words)!r})\nprint(*sys.modules, file=sys.stderr)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(run.stderr.splitlines()[-1].split())


@pytest.mark.parametrize("words", [("--version",), ("fits",)], ids=" ".join)
def test_version_and_mistakes_are_said_without_anything_heavy(words: tuple[str, ...]) -> None:
    assert not HEAVY & imported_by(*words)


def test_what_lists_no_commands_searches_no_packages_and_what_keeps_no_folder_locks_none() -> None:
    assert "importlib.metadata" not in imported_by("--version")
    assert not {"filelock", "asyncio", "ssl"} & imported_by("fit", "--help")


@pytest.mark.slow
def test_a_fit_loads_none_of_the_libraries_that_it_can_do_without(tmp_path: Path) -> None:
    picks = str(EXAMPLE / "landmarks.json")
    loaded = imported_by("fit", str(EXAMPLE / "scan.ply"), "--landmarks", picks, "-o", str(tmp_path / "out"))
    assert (tmp_path / "out" / "result.json").is_file()
    assert not {"flask", "scipy.stats", "scipy.interpolate"} & loaded


def test_the_program_does_not_search_what_is_installed_for_plugins_of_pydantic() -> None:
    """It would read the entry points of every package there is, 15 ms of a fit's 900."""
    code = "import contextlib, importlib.metadata, sys\nfrom breastrig.cli.entry import entry\n"
    code += "sys.argv = ['breastrig', '--version']\nwith contextlib.suppress(SystemExit):\n    entry()\n"
    code += "searched = []\nimportlib.metadata.distributions = lambda **words: searched.append(words) or []\n"
    code += "import breastrig.fitting.recipe\nassert 'pydantic' in sys.modules\nassert searched == []"
    surroundings = {name: value for name, value in os.environ.items() if name != "PYDANTIC_DISABLE_PLUGINS"}
    subprocess.run([sys.executable, "-c", code], env=surroundings, capture_output=True, check=True)


def test_the_settings_are_shown_without_the_service_and_without_scipy() -> None:
    assert not {"breastrig.service.service", "breastrig.fitting.fit"} & imported_by("config")


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["--help"])
    assert left.value.code == 0
    said = capsys.readouterr().out
    assert set(COMMANDS) <= set(said.split())


def parsers(root: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """The command's parser and those of its actions, by their words."""
    found = {}
    for action in root._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                found |= {name: below} | {f"{name} {more}": one for more, one in parsers(below).items()}
    return found


@pytest.mark.parametrize("command", COMMANDS)
def test_the_help_of_every_command_is_plain_english_for_each_of_its_options(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A percent sign that is not doubled puts a Python dict into argparse's text, or ends in an error."""
    found = {words: one for words, one in parsers(parser(command)).items() if words.split()[0] == command}
    for words, one in found.items():
        with pytest.raises(SystemExit) as left:
            main([*words.split(), "--help"])
        assert left.value.code == 0
        said = " ".join(capsys.readouterr().out.split())
        assert said.startswith(f"usage: breastrig {words} ")
        assert not re.search(r"\{'|%\(|option_strings|None|<class|\bobject at\b", said)
        sentences = re.sub(r"\W+", " ", said)
        for action in one._actions:
            if not isinstance(action, argparse._SubParsersAction):
                assert action.help, action.dest
                assert re.sub(r"\W+", " ", action.help.replace("%%", "%")).strip() in sentences


def test_what_is_no_command_is_refused_with_those_that_are(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["fits"])
    assert left.value.code == 2
    assert "purge" in capsys.readouterr().err


def test_the_package_runs_as_a_program_too() -> None:
    run = subprocess.run([sys.executable, "-m", "breastrig", "--version"], capture_output=True, text=True, check=True)
    assert run.stdout.startswith("BreastRig ")
