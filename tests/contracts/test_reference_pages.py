"""The reference pages have every landmark, measure, parameter and message of the program, with its numbers of today."""

import ast
import importlib.util
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

from breastrig.core.assets import packaged_models
from breastrig.drawings.patterns import PATTERNS
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.side_file import DrawingFile, RigFile
from breastrig.rig.model import Rig
from breastrig.scan.landmarks.names import known_name

OTHER_PIXELS = 0.002  # share: compression makes up to 0.00013, lines of another pattern 0.012


def program(file: Path) -> ModuleType:
    """A program of docs/reference, which is no package."""
    spec = importlib.util.spec_from_file_location(f"reference_{file.stem}", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def reference(repository: Path) -> ModuleType:
    return program(repository / "docs" / "reference" / "generate.py")


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def test_the_tables_are_those_of_the_program_and_a_part_that_is_left_out_or_old_is_found(
    reference: ModuleType, torso: Rig, repository: Path
) -> None:
    for name, blocks_of in reference.PAGES.items():
        text, blocks = (repository / "docs" / "reference" / name).read_text("utf-8"), blocks_of(torso)
        assert reference.faults(text, blocks) == [], f"{name}: run python docs/reference/generate.py"
        assert blocks
        for block, now in blocks.items():
            whole = f"<!-- data: {block} -->\n{now}<!-- end -->"
            assert whole in text
            assert reference.faults(text.replace(whole, ""), blocks) == [f"{block} is missing"]
            old = text.replace(whole, whole.replace(now, now[1:]))
            assert reference.faults(old, blocks) == [f"{block} is stale"]


def test_every_landmark_says_how_it_is_found_on_a_patient_and_on_a_scan(
    reference: ModuleType, torso: Rig, repository: Path
) -> None:
    text = (repository / "docs" / "reference" / "landmarks.md").read_text("utf-8")
    sections = re.split(r"^## ", text, flags=re.MULTILINE)
    for stem in reference.stems(torso):
        [section] = [each for each in sections if f"<!-- data: landmark {stem} -->" in each]
        assert re.search(r"^\*\*On the patient\.\*\* \w", section, re.MULTILINE), stem
        assert re.search(r"^\*\*On a scan\.\*\* \w", section, re.MULTILINE), stem
        assert f"](../pictures/landmarks/{stem}.webp)" in section, f"python docs/reference/pictures.py makes {stem}"


def test_every_term_of_a_landmark_is_read_in_files(reference: ModuleType, torso: Rig) -> None:
    known = {each.name: (each.label, each.latin) for each in torso.landmarks}
    for stem, row in reference.TERMS.items():
        sides = [("links", "_L"), ("dextra", "_R")] if f"{stem}_L" in known else [("", "")]
        for term in (term for cell in reference.glossary()[row] for term in cell.removesuffix(" T").split(", ")):
            for word, side in sides if term != "–" else ():
                assert known_name(f"{term} {word}", known) == stem + side


def test_every_measure_is_defined(reference: ModuleType, torso: Rig, repository: Path) -> None:
    text = (repository / "docs" / "reference" / "measures.md").read_text("utf-8")
    definitions = text.partition("| measure | definition |")[2].partition("\n\n")[0]
    defined = re.findall(r"^\| `(\w+)` \| \w.+ \|$", definitions, re.MULTILINE)
    assert defined == [row[0].strip("`") for row in reference.measure_rows(torso)], (
        "a row for each, in the table's order"
    )


def test_shares_of_true_values_held_are_those_of_the_data_file(repository: Path) -> None:
    text = (repository / "docs" / "reference" / "measures.md").read_text("utf-8")
    reasons = (repository / "model_assets" / "built" / "torso.known" / "measures.toml").read_text("utf-8")
    rows = [re.findall(r"(\d+) % \((\d+)\)", line) for line in text.splitlines() if line.count(" % (") == 3]
    assert len(rows) == 3
    for row in rows:
        for shares in zip(*row, strict=True):
            assert " / ".join(shares) in reasons


def test_every_key_of_a_rigs_side_file_is_explained(reference: ModuleType, repository: Path) -> None:
    text = (repository / "docs" / "reference" / "side_file.md").read_text("utf-8")
    side, drawing = text.split("## Drawings")[0], text.split("## Drawings")[1].split("## Skinning")[0]
    for part, model in ((side, RigFile), (drawing, DrawingFile)):
        said = {
            key: needed == "yes" for key, needed in re.findall(r"^\| `([^`]+)` \| (yes|no) \| .", part, re.MULTILINE)
        }
        assert said == reference.keys_of(model)
    files = set(re.findall(r"^\| `([a-z_]+\.(?:json|toml))` \|", text, re.MULTILINE))
    assert files == {file.name for file in (repository / "model_assets" / "built" / "torso.known").iterdir()}


def test_every_pattern_and_drawing_has_its_picture(reference: ModuleType, repository: Path) -> None:
    text = (repository / "docs" / "reference" / "patterns.md").read_text("utf-8")
    drawings = {d.name for path in packaged_models().values() for d in read_rig(path).drawings}
    for name in {*PATTERNS, *drawings} - {"tumour_at"}:
        assert f"](../pictures/patterns/{name}.webp)" in text, f"python docs/reference/pictures.py makes that of {name}"


def test_every_message_is_explained_and_one_that_is_left_out_or_not_said_is_found(
    reference: ModuleType, torso: Rig, repository: Path
) -> None:
    for name, messages in reference.MESSAGES.items():
        text, said = (repository / "docs" / "reference" / name).read_text("utf-8"), messages(torso)
        assert reference.missing(text, said) == [], f"add a row for each to a table of {name}"
        assert reference.unsaid(text, said) == [], f"the program does not say these any more: mend {name}"
        rows = reference.explained(text)
        assert min(len(said), len(rows)) > 20
        for one in said:
            assert reference.missing(reference.as_pattern(one).sub("", text), said) != []
        told = text.replace(f"| {rows[0]} |", f"| {rows[0]} Otherwise wait. |", 1)
        assert reference.unsaid(told, said) == [f"{rows[0]} Otherwise wait."]


def test_a_new_sentence_of_a_module_is_seen(reference: ModuleType) -> None:
    module = '''"""Not a message of anybody."""
COLOUR = "of another colour"
def judged(share):
    """Nor is this one."""
    log.warning("the log says more than a person needs")
    yield Reason(f"The skin is {COLOUR} on {100 * share:.0f} % of it", ("look at the light",))
    raise BadScan("This scan is not lit; scan again." if share else unknown_name("kind of light", share, ()))
'''
    found = reference.texts(ast.parse(module), "", raised=False)
    assert {each for each in found if len(each.split()) > 3} == {
        "The skin is of another colour on … % of it",
        "look at the light",
        "This scan is not lit; scan again.",
        '"…" is not a kind of light; known are: ….',
    }
    assert "look at the light" not in reference.texts(ast.parse(module), "judged", raised=True)


def test_the_pictures_are_those_of_the_model(torso: Rig, repository: Path) -> None:
    pictures, folder = program(repository / "docs" / "reference" / "pictures.py"), repository / "docs" / "pictures"
    made = pictures.all_pictures(torso)
    kept = {str(file.relative_to(folder)) for kind in ("landmarks", "patterns") for file in (folder / kind).iterdir()}
    assert kept == made.keys()
    other = {name: share_of_others(picture, folder / name) for name, picture in made.items()}
    assert max(other.values()) < OTHER_PIXELS, f"run python docs/reference/pictures.py: {other}"
    assert share_of_others(made["patterns/vertical.webp"], folder / "patterns" / "reduction.webp") > OTHER_PIXELS


def share_of_others(picture: np.ndarray, file: Path) -> float:
    """Share of the pixels that differ by more than compression makes them."""
    with Image.open(file) as kept:
        return float((np.abs(np.asarray(kept.convert("RGB"), dtype=float) - picture).max(axis=2) > 80).mean())
