"""Reads a fit's folder: the input of a transfer, a measure or a report.

Folders are copied between machines and versions, so everything in them is checked: contradictions are an error of one
sentence.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput, BadScan
from breastrig.core.private_files import is_ordinary, read_ordinary
from breastrig.core.units import METRES_PER_UNIT
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.files.result import (
    BODY,
    CHECKS,
    FIT_FILES,
    RESULT,
    UNCERTAINTY,
    ResultFile,
    ResultParameters,
    damaged,
    folder_name,
    parsed_result,
    read_result,
    result_text,
)
from breastrig.fitting.checks.basis import CheckBasis, read_basis
from breastrig.fitting.posterior import read_contribution
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.rotations import rotation_from_quaternion
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_posterior import Gaussian
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.scan.clean import Surface, compact
from breastrig.scan.hand_cuts import without_cuts
from breastrig.scan.limits import FILE_BYTES
from breastrig.scan.read import read_scan


@dataclass(frozen=True, eq=False)
class FitFolder:
    """One fit, read or just made; places are in the scan's own frame, in metres."""

    rig: Rig
    result: ResultFile
    surface: Surface  # the cleaned scan that was fitted
    vertices: Array  # (V, 3) m, the fitted model, refined or not
    landmarks: dict[str, Array]  # picked and not doubted, (3,) m
    seen: dict[str, Array]  # which the scan's colours show, (3,) m; of those not picked
    marks: dict[str, Array]  # on the scan's skin, (3,) m, of any names
    stance: str  # standing | supine | prone
    metres_per_unit: float
    parameters: RigParameters
    radii: Array | None = None  # (V,) m, each holds the vertex's true place with 90 %; None: an older fit
    body: Gaussian | None = None  # scales and weights, under the built-in prior; None: an older fit, or nothing is said
    checks: CheckBasis | None = None  # None: an older fit, or nothing can be checked

    @property
    def unit(self) -> str:
        """The scan's own: m, dm, cm, mm, in or ft."""
        return self.result.scan.unit

    @cached_property
    def fitted_scan(self) -> FittedScan:
        """The fitted scan, for making drawings on it and transferring them."""
        target = ScanTarget(self.surface.vertices, self.surface.faces)
        return FittedScan(
            target,
            self.vertices,
            self.landmarks,
            self.stance,
            self.radii,
            self.seen,
            self.result.predicted,
            self.wall,
            self.marks,
        )

    @cached_property
    def wall(self) -> ClosestPointSearch | None:
        """The chest wall that the scan's file names, m."""
        found = self.result.wall
        if found is None:
            return None
        return ClosestPointSearch(self.metres_per_unit * np.array(found.points), np.array(found.triangles))


def read_fit_folder(folder: Path, model: Path | None = None) -> FitFolder:
    """The fit in a folder that `breastrig fit` wrote; `model` is its rig, by default the package's.

    Raises BadInput for a folder that is no fit, that another rig has made, or that is damaged.
    """
    return fit_folder_of(folder, read_rig(model or default_rig_path()))


def fit_folder_of(folder: Path, rig: Rig) -> FitFolder:
    """The fit in a folder, as read_fit_folder, with a rig that has been read."""
    shown = folder_name(folder)
    result = checked_result(folder)
    found = _fit(result, lambda name, unit: _mesh_file(folder / name, unit), rig, shown)
    return _with_posterior(found, lambda name: _content(folder / name))


def _with_posterior(found: FitFolder, content: Callable[[str], bytes]) -> FitFolder:
    """The fit with what its files of these names say of its errors; empty ones say nothing."""
    radii, body = _radii(content(UNCERTAINTY), found.rig), read_contribution(content(BODY), found.rig)
    checks = read_basis(content(CHECKS), found.rig, found.parameters)
    return replace(found, radii=radii, body=body, checks=checks)


def _content(file: Path) -> bytes:
    """Empty where there is no such file."""
    with suppress(OSError):
        return read_ordinary(file, FILE_BYTES)
    return b""


def checked_result(folder: Path) -> ResultFile:
    """The fit's result; BadInput where there is none, or where it or a file beside it was exchanged."""

    def read(name: str) -> bytes | None:
        with suppress(OSError):
            return read_ordinary(folder / name, FILE_BYTES)
        return None

    result = read_result(folder)
    result.check_files(read, folder_name(folder))
    return result


def read_fit_files(folder: Path) -> dict[str, bytes]:
    """The readable files of a fit, by name; BadInput when there is no result.json."""
    found = {RESULT: result_text(folder)}
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


def fit_of_files(files: Mapping[str, bytes], rig: Rig, shown: str) -> FitFolder:
    """The fit from the contents of result.json, scan.ply and fitted.ply; `shown` names them in errors."""

    def mesh(name: str, unit: str) -> tuple[Array, Integers]:
        if name not in files:
            raise _missing(f"{shown}/{name}")
        return _mesh(files[name], f"{shown}/{name}", unit)

    result = parsed_result(files[RESULT], shown)
    result.check_files(files.get, shown)
    found = _fit(result, mesh, rig, shown)
    return _with_posterior(found, lambda name: files.get(name, b""))


def _fit(result: ResultFile, mesh: Callable[[str, str], tuple[Array, Integers]], rig: Rig, shown: str) -> FitFolder:
    """The fit from result.json and, by name and unit, the two meshes beside it."""
    if result.model.sha256 != rig.sha256:
        raise BadInput(
            f"{shown} was fitted with another model ({result.model.name}); fit the scan again, or give that model."
        )
    surface = Surface(*mesh("scan.ply", result.scan.unit), ())
    vertices, faces = mesh("fitted.ply", result.scan.unit)
    if not np.array_equal(faces, rig.faces) or len(vertices) != len(rig.template):
        raise BadInput(f"{shown}/fitted.ply is not the fitted model; fit the scan again.")
    return fitted(rig, result, surface, vertices, _parameters(shown, rig, result.parameters), shown=shown)


def fitted(
    rig: Rig,
    result: ResultFile,
    surface: Surface,
    vertices: Array,
    parameters: RigParameters,
    radii: Array | None = None,
    checks: CheckBasis | None = None,
    shown: str = "this fit",
) -> FitFolder:
    """A fit with the landmarks that its result names; BadInput where the rig has none of that name."""
    per_unit = METRES_PER_UNIT[result.scan.unit]
    asked_about = (*result.landmarks_not_followed, *result.landmarks_unusual)
    doubted = {name for doubt in asked_about for name in doubt.names}
    off_skin = {name for asked in result.marks_asked for name in asked.names}
    for field, names in (("landmarks_picked", result.landmarks_picked), ("landmarks_seen", result.landmarks_seen)):
        if not names.keys() <= result.landmarks.keys() & set(rig.landmark_names):
            raise damaged(shown, field)
    return FitFolder(
        rig=rig,
        result=result,
        surface=surface,
        vertices=vertices,
        landmarks={n: per_unit * np.array(at) for n, at in result.landmarks_picked.items() if n not in doubted},
        marks={n: per_unit * np.array(mark.point) for n, mark in result.marks.items() if n not in off_skin},
        seen={name: per_unit * np.array(result.landmarks[name]) for name in result.landmarks_seen},
        stance=result.stance,
        metres_per_unit=per_unit,
        parameters=parameters,
        radii=radii,
        checks=checks,
    )


def _radii(content: bytes, rig: Rig) -> Array | None:
    """(V,) m of uncertainty.bin; None for another model's, or where nothing is known."""
    if len(content) != 4 * len(rig.template):
        return None
    radii = 1e-3 * np.frombuffer(content, dtype="<f4").astype(np.float64)
    return radii if np.isfinite(radii).all() and (radii >= 0.0).all() else None


def _mesh_file(file: Path, unit: str) -> tuple[Array, Integers]:
    shown = f"{folder_name(file.parent)}/{file.name}"
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


def _parameters(shown: str, rig: Rig, found: ResultParameters) -> RigParameters:
    names = tuple(bone.name for bone in found.bones)
    if names != rig.bone_names or set(found.blendshapes) != set(rig.shape_names):
        raise BadInput(f"{shown}/{RESULT} names other bones or shapes than the model; fit the scan again.")
    quaternions = np.array([bone.rotation_xyzw for bone in found.bones])
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    if (lengths < 0.5).any():
        raise damaged(shown, "a bone's rotation")
    return RigParameters(
        rotations=rotation_from_quaternion(quaternions / lengths),
        translations=np.array([bone.translation_m for bone in found.bones]),
        scales=np.array([bone.scale for bone in found.bones]),
        weights=np.array([found.blendshapes[name] for name in rig.shape_names]),
    )
