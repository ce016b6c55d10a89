"""The model as programs load it."""

from pathlib import Path

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig

Model = Rig | str | Path | None  # loaded, its .glb, or None for the torso of the package


def load_model(path: str | Path | None = None) -> Rig:
    """The rigged model of a .glb with its side file (.json) beside it; without a path the torso of the package.

    Its arrays are in metres in the body frame (+X to the patient's left, +Y to the head, +Z to the front): template
    (V, 3), faces (F, 3), blendshapes (S, V, 3); it names its bones, shapes and landmarks.  Loading takes some tens of
    milliseconds: load once and hand it to `fit` when there are many scans.

    Raises BadModel with one sentence.
    """
    return read_rig(default_rig_path() if path is None else Path(path))


def loaded(model: Model) -> Rig:
    """The model itself, loaded where it is not yet."""
    return model if isinstance(model, Rig) else load_model(model)


def files_of(model: Model) -> tuple[Path, ...]:
    """The .glb and its side file, where the model was given as a file."""
    return (Path(model), Path(model).with_suffix(".json")) if isinstance(model, str | Path) else ()
