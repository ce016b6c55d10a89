"""All wheels that an installation needs, with their hashes, for a network that is closed: `make wheelhouse`.

    python server/packaging/wheelhouse.py FOLDER [EXTRA,EXTRA]

Writes FOLDER/*.whl and FOLDER/requirements.txt; there,
`pip install --no-index --find-links . --require-hashes -r requirements.txt` needs no network.
"""

import hashlib
import shutil
import subprocess
import sys
from pathlib import Path

EXTRAS = "server,users,mri,volume,dask,pacs,backup"


def line(wheel: Path) -> str:
    """A requirement with the hash of its wheel."""
    name, version = wheel.name.split("-")[:2]
    return f"{name.replace('_', '-').lower()}=={version} --hash=sha256:{hashlib.sha256(wheel.read_bytes()).hexdigest()}"


def main(folder: Path, extras: str = EXTRAS) -> None:
    repository = Path(__file__).resolve().parents[2]
    shutil.rmtree(folder, ignore_errors=True)
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--wheel-dir", str(folder)]
    subprocess.run([*command, f"breastrig[{extras}] @ {repository.as_uri()}"], check=True)
    wheels = sorted(folder.glob("*.whl"))
    (folder / "requirements.txt").write_text("\n".join(map(line, wheels)) + "\n")
    print(f"{len(wheels)} wheels, {sum(each.stat().st_size for each in wheels) / 1e6:.0f} MB in {folder}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:3])
