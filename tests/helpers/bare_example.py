"""The example's scans without their colours: in those that have some, landmarks are looked for in them as well."""

from pathlib import Path

import trimesh

from breastrig.core.assets import asset_folder


def write_bare_example(stance: str, path: Path) -> Path:
    """Writes a PLY of the example's `stance`, with its vertices and triangles alone."""
    scan = trimesh.load(asset_folder("example") / stance / "scan.ply", process=False)
    scan.visual = trimesh.visual.ColorVisuals()
    scan.export(path)
    return path
