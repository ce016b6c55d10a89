"""The files of the presets, and what a preset that names a base makes of it."""

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadSettings, unknown_name
from breastrig.core.private_files import shown


def preset_names() -> tuple[str, ...]:
    """The presets that ship with the package."""
    folder = resources.files("breastrig.fitting") / "presets"
    return tuple(sorted(Path(str(item)).stem for item in folder.iterdir() if item.name.endswith(".toml")))


def preset_text(name: str) -> str:
    """The file of a preset that ships with the package; BadSettings for another name."""
    if name not in preset_names():
        raise BadSettings(unknown_name("preset", shown(name), preset_names()))
    return (resources.files("breastrig.fitting") / "presets" / f"{name}.toml").read_text("utf-8")


def changed(base: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The base with what is given in its place; tables are gone into, stages by their names."""
    result = dict(base)
    for name, part in given.items():
        old = result.get(name)
        if isinstance(part, Mapping) and isinstance(old, Mapping):
            result[name] = changed(old, part)
        elif isinstance(part, Mapping) and isinstance(old, list):
            stages = {stage["name"]: stage for stage in old}
            unknown = next((stage for stage in part if stage not in stages), None)
            if unknown is not None:
                raise BadSettings(unknown_name("stage of the base", str(unknown), tuple(stages)))
            result[name] = [changed(stage, part.get(key, {})) for key, stage in stages.items()]
        else:
            result[name] = part
    return result
