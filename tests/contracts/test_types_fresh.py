"""The API is described once, in Python; what is generated from it must be what is committed.

wire.py -> openapi.json -> web/src/api/types.gen.ts.  The last step is a script for Node, the one that builds the page.
"""

import os
import subprocess
import sys
from pathlib import Path

SCRIPT = "scripts/generate-types.mjs"


def check_types(web: Path, packaging: Path) -> subprocess.CompletedProcess[str]:
    sys.path.insert(0, str(packaging))
    try:
        from build_page import find_node
    finally:
        sys.path.remove(str(packaging))
    path = find_node()
    assert path is not None, "no Node 20.19 or later: `make test` installs one"
    return subprocess.run(
        ["node", SCRIPT, "--check"],
        cwd=web,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_types_of_the_page_are_generated_from_the_api_description(repository: Path) -> None:
    answer = check_types(repository / "web", repository / "server/packaging")
    assert answer.returncode == 0, answer.stderr


def test_stale_types_are_found(repository: Path, tmp_path: Path) -> None:
    for name in ("server/breastrig/api/openapi.json", f"web/{SCRIPT}", "web/src/api/types.gen.ts"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes((repository / name).read_bytes())
    with (tmp_path / "web/src/api/types.gen.ts").open("a") as types:
        types.write("export type Stale = string;\n")
    answer = check_types(tmp_path / "web", repository / "server/packaging")
    assert answer.returncode != 0
    assert "npm run types" in answer.stderr
