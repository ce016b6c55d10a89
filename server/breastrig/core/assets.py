"""Where the files that belong to the program are: in an installed wheel and in a source checkout.

    name      wheel                        checkout
    model     breastrig/assets/model       model_assets/built
    example   breastrig/assets/example     model_assets/example
    web       breastrig/assets/web         web/dist

The wheel's folder wins where it is there; the checkout's path is returned otherwise, whether it is there or not,
so that the caller can say what is missing.
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
