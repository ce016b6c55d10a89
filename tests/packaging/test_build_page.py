"""When the page is rebuilt, and with which Node."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture(scope="module")
def build_page(repository: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("build_page", repository / "server/packaging/build_page.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def web(tmp_path: Path, build_page: ModuleType) -> Path:
    """A page that was built from the sources beside it."""
    for name, text in {
        "package.json": "{}",
        "index.html": "<p>",
        "src/main.ts": "1;",
        "dist/index.html": "<p>",
    }.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    (tmp_path / "dist" / ".built-from").write_text(build_page.sources_digest(tmp_path) + "\n")
    return tmp_path


@pytest.mark.parametrize(
    ("version", "answer"),
    [
        ("v20.18.3", False),
        ("v20.19.0", True),
        ("v21.7.3", False),
        ("v22.11.0", False),
        ("v22.12.0", True),
        ("v24.1.0\n", True),
        ("v8.9.0", False),
        ("nonsense", False),
    ],
)
def test_only_the_versions_of_node_that_vite_runs_on_are_taken(
    build_page: ModuleType, version: str, answer: bool
) -> None:
    assert build_page.is_new_enough(version) is answer


def test_a_page_is_fresh_until_one_of_its_sources_changes_or_it_is_gone(build_page: ModuleType, web: Path) -> None:
    (web / "node_modules").mkdir()
    for name in ("node_modules/three.js", "README.md"):  # it is not made from these
        (web / name).write_text("")
    assert build_page.is_page_fresh(web)
    source = web / "src" / "main.ts"
    source.write_text("2;")
    assert not build_page.is_page_fresh(web)
    source.write_text("1;")
    (web / "src" / "style.css").write_text("")
    assert not build_page.is_page_fresh(web)
    (web / "src" / "style.css").unlink()
    assert build_page.is_page_fresh(web)
    (web / "dist" / "index.html").unlink()
    assert not build_page.is_page_fresh(web)


def test_a_fresh_page_is_left_alone(build_page: ModuleType, web: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build_page, "run_npm", lambda *_: pytest.fail("npm was called"))
    build_page.ensure_page(web)


def test_without_node_the_reason_is_one_sentence(
    build_page: ModuleType, web: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(build_page, "find_node", lambda: None)
    with pytest.raises(build_page.CannotBuildPage, match=r"needs Node 20\.19 or later"):
        build_page.run_npm(web, "ci")
