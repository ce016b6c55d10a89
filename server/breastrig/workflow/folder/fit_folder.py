"""The folder that a fit has left, read back: what a transfer, a measure or a report starts from.

Folders are copied between machines and versions, so everything in them is checked: what does not fit together is an
error of one sentence.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput, BadScan
from breastrig.core.private_files import is_ordinary, read_ordinary
from breastrig.core.stances import Stance
from breastrig.core.units import METRES_PER_UNIT
from breastrig.geometry.rotations import rotation_from_quaternion
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.scan.clean import Surface, compact
from breastrig.scan.hand_cuts import without_cuts
from breastrig.scan.limits import FILE_BYTES
from breastrig.scan.read import read_scan
from breastrig.workflow.folder.fit_file_names import FIT_FILES, LANDMARKS_SEEN, RESULT, UNCERTAINTY

RESULT_BYTES = 4_000_000  # a result.json has some ten thousand


@dataclass(frozen=True, eq=False)
class FitFolder:
    """One fit; places are in the scan's own frame, in metres."""

    rig: Rig
    result: dict[str, Any]  # result.json
    surface: Surface  # the cleaned scan that was fitted
    vertices: Array  # (V, 3) m, the fitted model, refined or not
    landmarks: dict[str, Array]  # picked and not doubted, (3,) m
    seen: dict[str, Array]  # which the scan's colours show, (3,) m; none where any was picked
    stance: str  # standing | supine | prone
    metres_per_unit: float
    parameters: RigParameters
    radii: Array | None = None  # (V,) m, each holds the vertex's true place with 90 %; None: an older fit

    @property
    def unit(self) -> str:
        """The scan's own: m, dm, cm, mm, in or ft."""
        return str(self.result["scan"]["unit"])


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True, defer_build=True)


class _Scan(_Part):
    unit: Literal["m", "dm", "cm", "mm", "in", "ft"]


class _Model(_Part):
    name: str
    sha256: str


class _Bone(_Part):
    name: str
    rotation_xyzw: list[FiniteFloat] = Field(min_length=4, max_length=4)
    translation_m: list[FiniteFloat] = Field(min_length=3, max_length=3)
    scale: list[FiniteFloat] = Field(min_length=3, max_length=3)


class _Parameters(_Part):
    bones: list[_Bone]
    blendshapes: dict[str, FiniteFloat]


class _Doubted(_Part):
    names: list[str]


class _Result(_Part):
    """The part of result.json that is read back."""

    schema_: Literal["breastrig/result@1"] = Field(alias="schema")
    scan: _Scan
    model: _Model
    stance: Stance
    landmarks: dict[str, list[FiniteFloat]]
    landmarks_picked: dict[str, list[FiniteFloat]]
    landmarks_seen: dict[str, str] = {}
    landmarks_not_followed: list[_Doubted]
    landmarks_unusual: list[_Doubted] = []
    parameters: _Parameters


def read_fit_folder(folder: Path, model: Path | None = None) -> FitFolder:
    """What `breastrig fit` wrote there; `model` is the rig that it was made with, by default the package's.

    Raises BadInput for a folder that is no fit, that another rig has made, or that is damaged.
    """
    return fit_folder_of(folder, read_rig(model or default_rig_path()))


def fit_folder_of(folder: Path, rig: Rig) -> FitFolder:
    """As read_fit_folder, with a rig that has been read."""
    text = _result_text(folder)
    found = _fit(text, lambda name, unit: _mesh_file(folder / name, unit), rig, _shown(folder))
    with suppress(OSError):
        return replace(found, radii=_radii(read_ordinary(folder / UNCERTAINTY, FILE_BYTES), rig))
    return found


def read_fit_files(folder: Path) -> dict[str, bytes]:
    """Those of a fit's files that are there and can be read, by name; BadInput when there is no result.json."""
    found = {RESULT: _result_text(folder)}
    for name in FIT_FILES:
        with suppress(OSError):
            content = read_ordinary(folder / name, FILE_BYTES)
            if name not in found and len(content) <= FILE_BYTES:
                found[name] = content
    return found


def still_visible(fit: FitFolder, cuts: Sequence[Mapping[str, Any]]) -> FitFolder:
    """The fit with what is left of its scan by cuts made by hand (see scan/hand_cuts.py), also by those made since.

    BadScan where that is next to nothing.
    """
    left = without_cuts(fit.surface.vertices, fit.surface.faces, cuts)
    if len(left) == len(fit.surface.faces):
        return fit
    return replace(fit, surface=Surface(*compact(fit.surface.vertices, left), fit.surface.notes))


def _shown(folder: Path) -> str:
    return folder.resolve().name[:100]  # a message names no place outside of the folder


def _result_text(folder: Path) -> bytes:
    """The bytes of result.json; none when it is far too large to be one."""
    try:
        _shown(folder)
        text = read_ordinary(folder / RESULT, RESULT_BYTES)
    except OSError as error:
        raise BadInput(f"There is no fit in {folder.name[:100]}; give a folder that `breastrig fit` wrote.") from error
    return text if len(text) <= RESULT_BYTES else b""


def fit_of_files(files: Mapping[str, bytes], rig: Rig, shown: str) -> FitFolder:
    """As read_fit_folder, from the contents of result.json, scan.ply and fitted.ply; `shown` names them in errors."""

    def mesh(name: str, unit: str) -> tuple[Array, Integers]:
        if name not in files:
            raise _missing(f"{shown}/{name}")
        return _mesh(files[name], f"{shown}/{name}", unit)

    found = _fit(files[RESULT], mesh, rig, shown)
    return replace(found, radii=_radii(files.get(UNCERTAINTY, b""), rig))


def _fit(text: bytes, mesh: Callable[[str, str], tuple[Array, Integers]], rig: Rig, shown: str) -> FitFolder:
    """From result.json and, by name and unit, the two meshes beside it."""
    try:
        result = _Result.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"])) or "it is no result of a fit"
        raise BadInput(
            f"{shown}/result.json is damaged or of another version ({where}); fit the scan again."
        ) from error
    if result.model.sha256 != rig.sha256:
        raise BadInput(
            f"{shown} was fitted with another model ({result.model.name}); fit the scan again, or give that model."
        )
    per_unit = METRES_PER_UNIT[result.scan.unit]
    surface_vertices, surface_faces = mesh("scan.ply", result.scan.unit)
    vertices, faces = mesh("fitted.ply", result.scan.unit)
    if not np.array_equal(faces, rig.faces) or len(vertices) != len(rig.template):
        raise BadInput(f"{shown}/fitted.ply is not the fitted model; fit the scan again.")
    asked_about = (*result.landmarks_not_followed, *result.landmarks_unusual)
    doubted = {name for doubt in asked_about for name in doubt.names}
    places = {name: np.array(place) for name, place in result.landmarks_picked.items() if name not in doubted}
    seen = {name: np.array(result.landmarks.get(name, ())) for name in result.landmarks_seen}
    if any(place.shape != (3,) or name not in rig.landmark_names for name, place in seen.items()):
        raise BadInput(f"{shown}/result.json is damaged ({LANDMARKS_SEEN}); fit the scan again.")
    if any(place.shape != (3,) or name not in rig.landmark_names for name, place in places.items()):
        raise BadInput(f"{shown}/result.json is damaged (landmarks_picked); fit the scan again.")
    return FitFolder(
        rig=rig,
        result=_document(text),
        surface=Surface(surface_vertices, surface_faces, ()),
        vertices=vertices,
        landmarks={name: per_unit * place for name, place in places.items()},
        seen={name: per_unit * place for name, place in seen.items()},
        stance=result.stance,
        metres_per_unit=per_unit,
        parameters=_parameters(f"{shown}/result.json", rig, result.parameters),
    )


def _radii(content: bytes, rig: Rig) -> Array | None:
    """(V,) m of uncertainty.bin; None for another model's, or where nothing is known."""
    if len(content) != 4 * len(rig.template):
        return None
    radii = 1e-3 * np.frombuffer(content, dtype="<f4").astype(np.float64)
    return radii if np.isfinite(radii).all() and (radii >= 0.0).all() else None


def _document(text: bytes) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(text)
    return document


def _mesh_file(file: Path, unit: str) -> tuple[Array, Integers]:
    shown = f"{file.parent.resolve().name}/{file.name}"
    if not is_ordinary(file):
        raise _missing(shown)
    return _mesh(file, shown, unit)


def _mesh(source: Path | bytes, shown: str, unit: str) -> tuple[Array, Integers]:
    """(V, 3) m vertices and (F, 3) triangles."""
    try:
        mesh = read_scan(source, "ply", unit, texture=False)
    except BadScan as error:
        raise BadInput(f"{shown} is damaged; fit the scan again.") from error
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def _missing(shown: str) -> BadInput:
    return BadInput(f"{shown} is missing; fit the scan again with this version of BreastRig.")


def _parameters(file: str, rig: Rig, found: _Parameters) -> RigParameters:
    names = tuple(bone.name for bone in found.bones)
    if names != rig.bone_names or set(found.blendshapes) != set(rig.shape_names):
        raise BadInput(f"{file} names other bones or shapes than the model; fit the scan again.")
    quaternions = np.array([bone.rotation_xyzw for bone in found.bones])
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    if (lengths < 0.5).any():
        raise BadInput(f"{file} is damaged (a bone's rotation); fit the scan again.")
    return RigParameters(
        rotations=rotation_from_quaternion(quaternions / lengths),
        translations=np.array([bone.translation_m for bone in found.bones]),
        scales=np.array([bone.scale for bone in found.bones]),
        weights=np.array([found.blendshapes[name] for name in rig.shape_names]),
    )
