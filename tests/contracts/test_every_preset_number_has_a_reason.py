"""Numbers live in presets, each with its reason beside it.

A line of a preset that sets a number (or a list of numbers) must end in a comment that says why.
"""

import re
import tomllib
from pathlib import Path

SETS_A_NUMBER = re.compile(r"""^\s*(?P<key>[\w."-]+)\s*=\s*(?P<value>\[?\s*[-+]?(?:\d|inf|nan|\.\d).*)$""")
AT_LEAST = 8  # letters; shorter is a mark, not a reason


def lines_without_a_reason(text: str) -> list[str]:
    found = []
    for number, line in enumerate(text.splitlines(), start=1):
        match = SETS_A_NUMBER.match(line)
        if match and sum(letter.isalpha() for letter in match["value"].partition("#")[2]) < AT_LEAST:
            found.append(f"{number}: {line.strip()}")
    return found


def test_every_number_of_every_preset_has_a_reason(repository: Path) -> None:
    package, known = repository / "server/breastrig", repository / "model_assets/built/torso.known"
    folders = (package / "fitting/presets", known)
    presets = [path for folder in folders for path in sorted(folder.glob("*.toml"))]
    assert {"default", "paper", "verdict", "skin_map"} <= {path.stem for path in presets}
    for path in presets:
        text = path.read_text(encoding="utf-8")
        assert tomllib.loads(text)
        assert not lines_without_a_reason(text), f"{path.name}: end these lines in a comment that says why: # m; ..."


def test_a_bare_number_is_found() -> None:
    text = 'name = "default"\n[stop]\nlimit = 40\nsigma = 0.002  # m: the noise of the scanner\nsteps = [1, 2] # two\n'
    assert lines_without_a_reason(text) == ["3: limit = 40", "5: steps = [1, 2] # two"]
