"""What the README and the documents show works as printed."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers import serve_browser_tests
from helpers.blank_pictures import blank_pictures
from helpers.real_server import search_path

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


@pytest.fixture
def example(repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that programs of the documents are run in, with the example's files by the names that they use."""
    source = repository / "model_assets" / "example"
    for stance in ("standing", "supine"):
        shutil.copy(source / stance / "scan.ply", tmp_path / f"{stance}.ply")
    for name in ("scan.ply", "landmarks.json"):
        shutil.copy(source / "standing" / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    blank_pictures(monkeypatch)
    return tmp_path


def test_the_lines_in_python_fit_measure_and_carry(
    repository: Path, example: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names: dict[str, Any] = {}
    exec(python_block(repository / "README.md"), names)
    assert len(names["there"].lines) == 4
    said = capsys.readouterr().out
    assert said.startswith("good (")
    assert "'volume'" in said
    assert (example / "out" / "result.json").is_file()


@pytest.fixture(scope="module")
def served(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, str]]:
    """The data folder of a service and its address with its token; what this run has fitted is not fitted again."""
    data = tmp_path_factory.mktemp("data")
    serve = [sys.executable, str(Path(serve_browser_tests.__file__)), "serve", "--port", "0", "--data", str(data)]
    surroundings = {"PYTHONPATH": search_path(), "BREASTRIG_E2E_EXAMPLES": str(repository / "model_assets/example")}
    with subprocess.Popen(serve, stdout=subprocess.PIPE, text=True, env=os.environ | surroundings) as server:
        try:
            assert server.stdout is not None
            address = re.search(r"http://\S+", server.stdout.readline())
            assert address
            yield data, address[0]
        finally:
            server.terminate()


def run_with(address: str, program: str) -> dict[str, Any]:
    """The names of a document's program that has run, asking the service at this address."""
    client = program.replace("http://127.0.0.1:8321/?token=...", address)
    assert client != program
    client = client.replace("time.sleep(0.5)", "time.sleep(0.02)")  # a person has more time
    names: dict[str, Any] = {}
    exec(client, names)
    return names


def test_the_python_client_does_a_whole_fit(
    repository: Path, example: Path, served: tuple[Path, str], capsys: pytest.CaptureFixture[str]
) -> None:
    data, address = served
    run_with(address, python_block(repository / "docs" / "reference" / "http.md"))
    said = capsys.readouterr().out
    assert "iterated" in said
    assert (example / "report.pdf").stat().st_size > 1000
    with zipfile.ZipFile(example / "result.zip") as packed:
        assert packed.namelist() == [*FIT_FILES, "plan.json"]
    assert list((data / "cases").iterdir()) == []  # it deletes what it has uploaded
    assert "'mean'" in said.splitlines()[-1]


def test_the_api_page_runs_from_top_to_bottom(repository: Path, example: Path, served: tuple[Path, str]) -> None:
    """Python and HTTP of one case: both give the same numbers, and nothing of the case is left."""
    blocks = re.findall(r"```python\n(.*?)```", (repository / "docs/reference/api.md").read_text(), re.DOTALL)
    data, address = served
    names = run_with(address, "".join(blocks))
    standing, result = names["standing"], names["result"]
    assert standing.verdict.level == result["verdict"]["level"]
    assert standing.line_error_mm == pytest.approx(result["line_error_mm"], abs=0.1)
    assert len(names["there"].lines) <= len(names["shown"]["shapes"])
    assert list((data / "cases").iterdir()) == []
    assert not (example / "patient").exists()
    for name in ("report.pdf", "result.zip", "out/result.json", "report/measures.csv"):
        assert (example / name).stat().st_size > 1000


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
