"""NAME.known/ beside NAME.glb: what was estimated for a rig, bound to it by hash; rig/known.py lists the files.

rig.json there says of which rig: {"schema": "breastrig/known@1", "rig_sha256": ...}.  A rig that was changed since is
another rig, of which nothing is known until somebody has looked and binds the folder anew (`breastrig model bind`).
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, Field, ValidationError

from breastrig.core.errors import BadModel
from breastrig.core.private_files import read_ordinary
from breastrig.rig.known import NOT_CALIBRATED

BINDING = "rig.json"
FILE_BYTES = 10_000_000  # the torso's largest has 22 thousand


class _Binding(BaseModel):
    schema_: Literal["breastrig/known@1"] = Field("breastrig/known@1", alias="schema")
    rig_sha256: str


def known_paths(glb: Path) -> tuple[Path, ...]:
    """The files beside this rig."""
    folder = glb.with_suffix(".known")
    try:
        return tuple(sorted(file for file in folder.glob("*") if file.suffix in (".json", ".toml")))
    except OSError:  # no such name can be
        return ()


def read_known(glb: Path, sha256: str) -> dict[str, str]:
    """Name -> text of the data estimated for the rig with this hash; empty if there are none of this rig."""
    texts = {path.name: _text(path) for path in known_paths(glb)}
    binding = texts.pop(BINDING, None)
    return texts if binding is not None and _bound(binding) == sha256 else {}


def known_words(glb: Path, known: Mapping[str, str]) -> str:
    """A summary of the known data, one line for people."""
    if known:
        return f"known of this rig: {', '.join(known)}"
    if known_paths(glb):
        return f"{NOT_CALIBRATED}: {glb.stem}.known is of another one or of none; see `breastrig model bind`."
    return f"{NOT_CALIBRATED}: there is no folder {glb.stem}.known beside it."


def bind_known(glb: Path, sha256: str) -> Path:
    """Binds the folder to the rig with this hash; returns the file with the hash. Raises BadModel without a folder."""
    folder = glb.with_suffix(".known")
    try:
        (folder / BINDING).write_text(
            json.dumps({"schema": "breastrig/known@1", "rig_sha256": sha256}, indent=1) + "\n"
        )
    except OSError as error:
        raise BadModel(f"{folder.name} beside {glb.name} cannot be written ({error.strerror}).") from error
    return folder / BINDING


def _bound(text: str) -> str | None:
    """The hash that the folder is bound to; None when it names none."""
    try:
        return _Binding.model_validate_json(text).rig_sha256
    except ValidationError:
        return None


def _text(file: Path) -> str:
    try:
        content = read_ordinary(file, FILE_BYTES)
        if len(content) <= FILE_BYTES:
            return content.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadModel(f"{file.parent.name}/{file.name} cannot be read; mend it or take it away.") from error
    raise BadModel(f"{file.parent.name}/{file.name} is larger than {FILE_BYTES // 10**6} MB; take it away.")
