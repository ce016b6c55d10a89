"""What the README and the documents show works as printed."""

import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from breastrig.files.result import FIT_FILES
from breastrig.gltf.read_rig import default_rig_path, read_rig

pytestmark = pytest.mark.long


def python_block(document: Path) -> str:
    """The document's first Python block."""
    found = re.search(r"```python\n(.*?)```", document.read_text(), re.DOTALL)
    assert found
    return found[1]


@pytest.fixture(scope="module")
def documents(repository: Path) -> list[Path]:
    """All that people read before they start."""
    return [*repository.glob("*.md"), *(repository / "docs").rglob("*.md")]


def test_the_lines_in_python_fit_measure_and_carry(repository: Path, tmp_path: Path) -> None:
    example = repository / "model_assets" / "example"
    for stance in ("standing", "supine"):
        shutil.copy(example / stance / "scan.ply", tmp_path / f"{stance}.ply")
    shutil.copy(example / "standing" / "landmarks.json", tmp_path)
    lines = python_block(repository / "README.md") + "assert len(there.lines) == 4\n"
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", lines], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("good (")
    assert "'volume'" in run.stdout
    assert (tmp_path / "out" / "result.json").is_file()


@contextmanager
def served(data: Path) -> Iterator[str]:
    """The address with its token of a service of this data folder."""
    serve = [sys.executable, "-m", "breastrig.cli.main", "serve", "--port", "0", "--data", str(data)]
    with subprocess.Popen(serve, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            address = re.search(r"http://\S+", server.stdout.readline())
            assert address
            yield address[0]
        finally:
            server.terminate()


def run_with(address: str, program: str, folder: Path) -> str:
    """What a program of a document prints in this folder, asking the service at this address."""
    client = program.replace("http://127.0.0.1:8321/?token=...", address)
    assert client != program
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", client], cwd=folder, capture_output=True, text=True, timeout=240
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


def test_the_python_client_does_a_whole_fit(repository: Path, tmp_path: Path) -> None:
    for name in ("scan.ply", "landmarks.json"):
        shutil.copy(repository / "model_assets" / "example" / "standing" / name, tmp_path)
    with served(tmp_path / "data") as address:
        said = run_with(address, python_block(repository / "docs" / "reference" / "http.md"), tmp_path)
        cases = list((tmp_path / "data" / "cases").iterdir())
    assert "iterated" in said
    assert (tmp_path / "report.pdf").stat().st_size > 1000
    with zipfile.ZipFile(tmp_path / "result.zip") as packed:
        assert packed.namelist() == [*FIT_FILES, "plan.json"]
    assert cases == []  # it deletes what it has uploaded
    assert "'mean'" in said.splitlines()[-1]


def test_the_api_page_runs_from_top_to_bottom(repository: Path, tmp_path: Path) -> None:
    """Python and HTTP of one case: both give the same numbers, and nothing of the case is left."""
    example = repository / "model_assets" / "example"
    for stance in ("standing", "supine"):
        shutil.copy(example / stance / "scan.ply", tmp_path / f"{stance}.ply")
    shutil.copy(example / "standing" / "landmarks.json", tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (repository / "docs/reference/api.md").read_text(), re.DOTALL)
    both = "print('SAME', standing.verdict.level == result['verdict']['level'], "
    both += "abs(standing.line_error_mm - result['line_error_mm']) < 0.1, len(there.lines) <= len(shown['shapes']))\n"
    with served(tmp_path / "data") as address:
        said = run_with(address, "".join([*blocks, both]), tmp_path)
        cases = list((tmp_path / "data" / "cases").iterdir())
    assert said.splitlines()[-1] == "SAME True True True"
    assert cases == []
    assert not (tmp_path / "patient").exists()
    for name in ("report.pdf", "result.zip", "out/result.json", "report/measures.csv"):
        assert (tmp_path / name).stat().st_size > 1000


def test_links_and_pictures_lead_somewhere(documents: list[Path]) -> None:
    for document in documents:
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", document.read_text()):
            assert target.startswith("https://") or (document.parent / target).exists(), f"{document.name}: {target}"


def test_the_readme_stays_a_page(repository: Path) -> None:
    assert len((repository / "README.md").read_text().splitlines()) <= 100


def test_the_model_has_as_many_parts_as_the_documents_say(repository: Path) -> None:
    rig = read_rig(default_rig_path())
    parts = {"bones": len(rig.bones), "blendshapes": len(rig.shapes), "landmarks": len(rig.landmarks)}
    for name in ("README.md", "docs/explanation/model_card.md", "model_assets/README.md"):
        said = re.findall(r"\b(\d+) (?:scalable )?(bones|blendshapes|landmarks)\b", (repository / name).read_text())
        assert {part for _, part in said} == set(parts), name
        assert {part: int(count) for count, part in said} == parts, f"the model has changed: mend the numbers in {name}"


def test_every_decision_that_is_named_is_there(repository: Path, project_texts: dict[str, str]) -> None:
    named = {number for text in project_texts.values() for number in re.findall(r"docs/decisions/(\d{4})", text)}
    assert named
    assert named <= {file.name[:4] for file in (repository / "docs/decisions").glob("0*.md")}
