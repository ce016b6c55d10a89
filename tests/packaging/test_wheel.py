"""A built wheel is complete: page, model, example, presets and API description are inside, once each.

sdist and wheel are built as `pip` would, the wheel from the sdist.  `npm` is booby-trapped meanwhile, since a
package that carries its built page must not need Node.
"""

import os
import subprocess
import sys
import tarfile
import zipfile
from collections import Counter
from pathlib import Path

import pytest

pytestmark = pytest.mark.long

NEEDED = {
    "breastrig/assets/web/index.html",
    "breastrig/assets/model/torso.glb",
    "breastrig/assets/model/torso.json",
    "breastrig/assets/model/MANIFEST.json",
    "breastrig/assets/model/drawings/lumpectomy.json",
    "breastrig/assets/model/drawings/anatomy.json",
    "breastrig/assets/example/standing/scan.ply",
    "breastrig/assets/example/standing/landmarks.json",
    "breastrig/assets/example/supine/scan.ply",
    "breastrig/assets/example/supine/landmarks.json",
    "breastrig/assets/example/marked/scan.zip",
    "breastrig/assets/example/marked/landmarks.json",
    "breastrig/assets/example/mri/scan.nii.gz",
    "breastrig/assets/example/mri/landmarks.json",
    "breastrig/fitting/presets/default.toml",
    "breastrig/fitting/presets/paper.toml",
    "breastrig/api/openapi.json",
    "breastrig/py.typed",
}


@pytest.fixture(scope="module")
def built(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The sdist and the wheel made from it, by kind."""
    subprocess.run([sys.executable, repository / "server/packaging/build_page.py"], check=True)
    out, trap = tmp_path_factory.mktemp("built"), tmp_path_factory.mktemp("trap")
    (trap / "npm").write_text("#!/bin/sh\necho 'npm was called though the page is fresh' >&2\nexit 1\n")
    (trap / "npm").chmod(0o755)
    answer = subprocess.run(
        [sys.executable, "-m", "build", "--no-isolation", "--outdir", out, repository],
        env=os.environ | {"PATH": f"{trap}{os.pathsep}{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return {"sdist": next(out.glob("*.tar.gz")), "wheel": next(out.glob("*.whl"))}


@pytest.fixture(scope="module")
def names_in_the_wheel(built: dict[str, Path]) -> list[str]:
    with zipfile.ZipFile(built["wheel"]) as wheel:
        return wheel.namelist()


def test_the_wheel_holds_page_model_example_presets_and_api_once_and_nothing_else(
    names_in_the_wheel: list[str],
) -> None:
    assert not NEEDED - set(names_in_the_wheel)
    assert not [name for name, count in Counter(names_in_the_wheel).items() if count > 1]
    roots = {name.split("/")[0] for name in names_in_the_wheel}
    assert {root for root in roots if not root.endswith(".dist-info")} == {"breastrig"}
    assert not [name for name in names_in_the_wheel if "__pycache__" in name or "/." in name]


def test_the_studies_have_a_wheel_of_their_own(repository: Path, tmp_path: Path) -> None:
    """With the cohort; the program's wheel has neither."""
    project = repository / "server/breastrig_studies"
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path, project],
        check=True,
        capture_output=True,
    )
    with zipfile.ZipFile(next(tmp_path.glob("breastrig_studies-*.whl"))) as wheel:
        names = set(wheel.namelist())
    held = {f"breastrig_studies/{file.relative_to(project).as_posix()}" for file in project.rglob("*.py")}
    assert held | {"breastrig_studies/assets/cohort/bodies.npz"} <= names


def test_the_page_in_the_wheel_is_the_one_that_was_built(built: dict[str, Path], repository: Path) -> None:
    dist = repository / "web" / "dist"
    wanted = {
        p.relative_to(dist).as_posix(): p.read_bytes() for p in dist.rglob("*") if p.is_file() and p.name[0] != "."
    }
    prefix = "breastrig/assets/web/"
    with zipfile.ZipFile(built["wheel"]) as wheel:
        found = {n.removeprefix(prefix): wheel.read(n) for n in wheel.namelist() if n.startswith(prefix)}
    assert found == wanted


def test_the_wheel_says_its_licence_and_its_python(built: dict[str, Path]) -> None:
    with zipfile.ZipFile(built["wheel"]) as wheel:
        metadata = next(wheel.read(n).decode() for n in wheel.namelist() if n.endswith(".dist-info/METADATA"))
    assert "License-Expression: Apache-2.0" in metadata
    assert "Requires-Python: >=3.11" in metadata


def test_the_sdist_carries_the_built_page_and_the_sources(built: dict[str, Path]) -> None:
    with tarfile.open(built["sdist"]) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    assert {"web/dist/index.html", "web/package.json", "server/packaging/hatch_build.py", "LICENSE"} <= names
    assert not [name for name in names if "node_modules" in name]
