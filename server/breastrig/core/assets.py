"""Locates the files that belong to the program, in an installed wheel or a source checkout.

    name      wheel                        checkout
    model     breastrig/assets/model       model_assets/built
    example   breastrig/assets/example     model_assets/example
    web       breastrig/assets/web         web/dist

The wheel's folder has priority; otherwise the checkout's path is returned, whether it exists or not, so that the caller
can report what is missing.
"""

from pathlib import Path
from typing import Literal

PACKAGE = Path(__file__).resolve().parent.parent
CHECKOUT = {
    "model": "model_assets/built",
    "example": "model_assets/example",
    "web": "web/dist",
}


def asset_folder(name: Literal["model", "example", "web"]) -> Path:
    """The folder of that name; it may be missing when it has not been built."""
    packaged = PACKAGE / "assets" / name
    return packaged if packaged.is_dir() else PACKAGE.parent.parent / CHECKOUT[name]


def packaged_models() -> dict[str, Path]:
    """The .glb of each model that comes with BreastRig, by name; the first is the default."""
    folder = asset_folder("model")
    others = sorted(path for path in folder.glob("*/*.glb") if path.stem == path.parent.name)
    return {path.stem: path for path in (folder / "torso.glb", *others)}


def model_path(name: str | Path) -> Path:
    """The .glb of a packaged model by its name (`male`), or else the path itself."""
    return packaged_models().get(str(name), Path(name))
