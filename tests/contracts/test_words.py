"""Words that are not to come back: each has a standard term of the field, or a plain one, in its place."""

import re
import subprocess
from pathlib import Path

import pytest

SERVER = ("server/*.py", "server/*.toml", "server/*.md", "server/*.html")
PAGE = ("web/src/*.ts", "web/src/languages/en.json", "web/*.md")
DOCS = ("docs/*.md", "README.md", "CONTRIBUTING.md")
ALL = (*SERVER, *PAGE, *DOCS)
INSTEAD = {  # pattern, between word boundaries: (the word to use, where)
    "[Tt]old": ("known, observed, informed", ALL),
    "[Ww]ho (lies|stands)": ("supine, standing", ALL),
    "carr(y|ies|ied) out": ("run", ALL),
    "learnt": ("estimated on", ALL),
    "begun": ("started; in a solver: initial point", (*SERVER, *DOCS)),
    "freed": ("the active set", ALL),
    "let(s|ting)? go": ("rejected; of a lock: released", (*SERVER, *DOCS)),  # in the page: of a pointer
    "stands? in(?! a row)": ("is in", ALL),
    "told_by_a_person": ("picked_names", ALL),
    "two_openings|opened_iterates": ("second_start", ALL),
    "second_look|going_on_without": ("refit_without", ALL),
    "further_jobs": ("jobs", ALL),
    "made_ready|make_ready": ("prepare_fit, precompute", ALL),
    "asking_client": ("client_key", ALL),
    "lies_or_stands": ("stance", ALL),
    r"\\w*(Seen|Hollow)": ("an observation, named by its source: ColourObservation, ReliefObservation", SERVER),
    "hollow_terms|seen_hollows|SeenHollow": ("relief_terms, relief_observations, ReliefObservation", ALL),
    "let_go": ("rejected", ALL),
}


def lines(repository: Path, patterns: tuple[str, ...]) -> list[tuple[str, int, str]]:
    files = subprocess.run(["git", "ls-files", *patterns], cwd=repository, capture_output=True, text=True, check=True)
    names = [name for name in files.stdout.split() if ".gen." not in name and (repository / name).is_file()]
    return [
        (name, number, line)
        for name in names
        for number, line in enumerate((repository / name).read_text("utf-8").splitlines(), 1)
    ]


@pytest.mark.parametrize("where", sorted({where for _, where in INSTEAD.values()}))
def test_words_that_have_a_better_one_are_not_used(where: tuple[str, ...], repository: Path) -> None:
    words = {re.compile(rf"\b({word})\b"): instead for word, (instead, there) in INSTEAD.items() if there == where}
    some = re.compile("|".join(word.pattern for word in words))
    found = [
        (instead, f"{name}:{number}: {line.strip()}")
        for name, number, line in lines(repository, where)
        if some.search(line)
        for word, instead in words.items()
        if word.search(line)
    ]
    assert found == [], "use instead what stands before each"


def test_names_of_tests_keep_to_the_same_words(repository: Path) -> None:
    names = [line for _, _, line in lines(repository, ("tests/*.py",)) if re.match(r"\s*def test_", line)]
    assert len(names) > 1000
    spoken = "|".join(pattern.replace(" ", "_") for pattern in INSTEAD if not pattern.startswith("\\"))
    word = re.compile(rf"(?<=_)({spoken})(?=_|\()")
    found = [name for name in names if word.search(name)]
    assert found == [], "rename these: INSTEAD above has the word to use for each"
