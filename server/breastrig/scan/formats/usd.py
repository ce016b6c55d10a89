"""The meshes of USDZ and USD files, by Pixar's own library; runs in a process of its own (usd_process.py).

A USD layer can name other layers and files anywhere, which the library would open.  So the package's layers are put
into a private folder under names of ours, and all that they name but one another is struck out before anything is
composed.  Pictures are taken from the package by their names.
"""

import io
import posixpath
import zipfile
import zlib
from collections.abc import Iterator
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.core.scratch import scratch_folder
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.formats.polygons import fans, split
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE, TOO_MANY_TRIANGLES, TRIANGLES, USD_PRIMS, VERTICES, ZIP_ENTRIES
from breastrig.scan.pictures.companions import PICTURES, UNPLACED, Companions, Reader
from breastrig.scan.pictures.tiles import painted_by_tiles
from breastrig.scan.piece import Piece, Pieces, srgb_bytes

CRATE = b"PXR-USDC"
LAYERS = ("usd", "usda", "usdc")
BY_DEFAULT = "cm"  # what the standard says of files that name no unit
DAMAGED = "This USD file is damaged, or holds nothing that can be read here; export the scan as GLB, PLY or OBJ."
NESTED = "This USD file keeps its mesh in other files; export the scan as one USDZ, or as GLB, PLY or OBJ."


def usd_pieces(data: bytes, texture: bool) -> Pieces:
    """The scene's meshes, +Y up. Raises BadScan or TooLarge with a sentence."""
    from pxr import UsdUtils

    silent = UsdUtils.CoalescingDiagnosticDelegate()  # its warnings name what is in the file
    try:
        layers, files = _opened(data)
        with scratch_folder() as folder:
            return _Scene(folder, layers, Companions(lambda: files), texture).pieces()
    except BadInput:
        raise
    except MemoryError as error:
        raise TooLarge("Reading this scan needs more memory than there is; simplify it first.") from error
    except Exception as error:  # a parser of untrusted bytes can raise anything
        raise BadScan(DAMAGED) from error
    finally:
        del silent


def _opened(data: bytes) -> tuple[dict[str, bytes], dict[str, Reader]]:
    """The layers by their names, the first of them first, and the package's pictures."""
    if not data.startswith(b"PK"):
        return {"scan": data}, {}
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as package:
            entries = package.infolist()
            if len(entries) > ZIP_ENTRIES:
                raise TooLarge(f"This USDZ holds {len(entries):,} files, more than the {ZIP_ENTRIES:,} allowed.")
            if any(entry.compress_type != zipfile.ZIP_STORED for entry in entries):
                raise BadScan("This USDZ is compressed, which the format does not allow; export it again.")
            wanted = [entry for entry in entries if _ending(entry.filename) in (*LAYERS, *PICTURES)]
            if sum(entry.file_size for entry in wanted) > FILE_BYTES:
                raise TooLarge(f"This USDZ unpacks to more than the {FILE_BYTES // MEBIBYTE} MB allowed.")
            content = {entry.filename: package.read(entry) for entry in wanted}
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError) as error:
        raise BadScan(DAMAGED) from error
    layers = {name: each for name, each in content.items() if _ending(name) in LAYERS}
    return layers, {name: partial(bytes, each) for name, each in content.items() if name not in layers}


def _ending(name: str) -> str:
    return PurePosixPath(name.lower()).suffix.removeprefix(".")


class _Scene:
    """The scene of the first layer and the layers that it names."""

    def __init__(self, folder: Path, layers: dict[str, bytes], files: Companions, texture: bool) -> None:
        from pxr import Sdf, Usd, UsdGeom

        places = {
            posixpath.normpath(name): folder / f"{number}.{'usdc' if content.startswith(CRATE) else 'usda'}"
            for number, (name, content) in enumerate(layers.items())
        }
        for place, content in zip(places.values(), layers.values(), strict=True):
            place.write_bytes(content)
        self._layers = [
            Sdf.Layer.FindOrOpen(str(place)) for place in places.values()
        ]  # with what is struck out of them
        if self._layers[0] is None:
            raise ValueError("no layer")
        self._is_nested = False
        for name, layer in zip(places, self._layers, strict=True):
            if layer is not None:
                self._is_nested |= _strike_out(layer, posixpath.dirname(name), places)
        self._stage = Usd.Stage.Open(self._layers[0])
        if any(not each.anonymous and each not in self._layers for each in self._stage.GetUsedLayers()):
            raise ValueError("a layer from elsewhere")
        self._files, self._texture = files, texture
        self._places = UsdGeom.XformCache()
        self._unit, self._is_default = BY_DEFAULT, not self._stage.HasAuthoredMetadata("metersPerUnit")
        self._factor = 1.0
        if not self._is_default:
            metres = UsdGeom.GetStageMetersPerUnit(self._stage)
            named = (unit for unit, each in METRES_PER_UNIT.items() if abs(metres - each) < 1e-6 * each)
            self._unit = next(named, "m")
            self._factor = metres / METRES_PER_UNIT[self._unit]  # not 1 where there is no name for it
        self._has_z_up = UsdGeom.GetStageUpAxis(self._stage) == UsdGeom.Tokens.z

    def pieces(self) -> Pieces:
        from pxr import UsdGeom

        pieces: list[Piece] = []
        triangles = vertices = 0
        for number, prim in enumerate(self._stage.Traverse()):
            if number > USD_PRIMS:
                raise TooLarge(f"This USD file has more than the {USD_PRIMS:,} parts allowed; join its meshes.")
            if not prim.IsA(UsdGeom.Mesh) or UsdGeom.Imageable(prim).ComputeVisibility() == UsdGeom.Tokens.invisible:
                continue
            for piece in self._mesh(UsdGeom.Mesh(prim)):
                triangles, vertices = triangles + len(piece.faces), vertices + len(piece.vertices)
                if triangles > TRIANGLES or vertices > VERTICES:
                    raise TooLarge(TOO_MANY_TRIANGLES)
                pieces.append(piece)
        if not pieces:
            raise BadScan(NESTED if self._is_nested else DAMAGED)
        return Pieces(tuple(pieces), notes=self._files.notes(), unit=self._unit, unit_by_default=self._is_default)

    def _mesh(self, mesh: Any) -> Iterator[Piece]:
        """The mesh as one piece for each material."""
        points = np.asarray(mesh.GetPointsAttr().Get(), np.float64).reshape(-1, 3)
        counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get(), np.int64).ravel()
        indices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get(), np.int64).ravel()
        if (counts < 0).any() or counts.sum() != len(indices) or (len(indices) and not _within(indices, len(points))):
            raise ValueError("its polygons name vertices that do not exist")
        corners, polygons = fans(counts)
        if mesh.GetOrientationAttr().Get() == "leftHanded":
            corners = corners[:, ::-1]
        matrix = np.array(self._places.GetLocalToWorldTransform(mesh.GetPrim()), np.float64)
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            corners = corners[:, ::-1]
        placed = self._factor * (points @ matrix[:3, :3] + matrix[3, :3])
        if self._has_z_up:
            placed = np.column_stack([placed[:, 0], placed[:, 2], -placed[:, 1]])
        faces = indices[corners] if len(corners) else np.zeros((0, 3), np.int64)
        for prim, own in _parts(mesh, polygons):
            yield from self._pieces(prim, mesh, placed, faces[own], corners[own], polygons[own])

    def _pieces(
        self, prim: Any, mesh: Any, points: Array, faces: Integers, corners: Integers, polygons: Integers
    ) -> tuple[Piece, ...]:
        from pxr import UsdGeom

        variables = UsdGeom.PrimvarsAPI(mesh)
        written, name, tint = self._painted(prim) if self._texture else (None, None, None)
        if written is not None:
            uv = _values(variables, [name, "st", "st0", "UVMap"], 2)
            placed = _placed(points, faces, corners, uv)
            if placed is None and self._files.picture(written) is not None:
                self._files.note(UNPLACED)
            painted = () if placed is None else painted_by_tiles(placed, written, self._files)
            if any(each.picture for each in painted):
                return painted
        return (_coloured(_values(variables, ["displayColor"], 3), points, faces, corners, polygons, tint),)

    def _painted(self, prim: Any) -> tuple[str | None, str | None, tuple[int, int, int] | None]:
        """(the picture's name, name of its coordinates, one colour) of what the prim is painted with."""
        from pxr import UsdShade

        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        surface = material.ComputeSurfaceSource()[0] if material else None
        inputs = [surface.GetInput(name) for name in ("diffuseColor", "emissiveColor")] if surface else []
        sources = [found[0] for each in inputs if each and (found := each.GetConnectedSources()[0])]
        if not sources:
            plain = inputs[0].Get() if inputs and inputs[0] else None
            return None, None, None if plain is None else _one(srgb_bytes(np.array([plain], np.float64))[0])
        shader = UsdShade.Shader(sources[0].source.GetPrim())
        asked = shader.GetInput("file").Get() if shader.GetInput("file") else None
        if asked is None:
            return None, None, None
        reader = shader.GetInput("st").GetConnectedSources()[0] if shader.GetInput("st") else []
        name = UsdShade.Shader(reader[0].source.GetPrim()).GetInput("varname") if reader else None
        return str(asked.path) or None, str(name.Get()) if name else None, None


def _placed(points: Array, faces: Integers, corners: Integers, uv: Array | None) -> Piece | None:
    """The triangles with their places in a picture, given for each vertex or corner; None where for neither."""
    if uv is None or len(uv) == len(points):
        return None if uv is None else Piece(points, faces, uv=uv)
    if len(uv) <= corners.max(initial=-1):
        return None
    which, parted, values = split(faces, uv[corners])
    return Piece(points[which], parted, uv=values)


def _coloured(
    linear: Array | None,
    points: Array,
    faces: Integers,
    corners: Integers,
    polygons: Integers,
    tint: tuple[int, int, int] | None,
) -> Piece:
    """The triangles with the colours of vertices, polygons, corners or all of them; `linear` (N, 3)."""
    if linear is None or not len(linear):
        return Piece(points, faces, tint=tint)
    colours = srgb_bytes(linear)
    if len(colours) == len(points):
        return Piece(points, faces, colours)
    if len(colours) == 1:
        return Piece(points, faces, tint=_one(colours[0]))
    of_corners = colours[polygons][:, None].repeat(3, axis=1) if len(colours) > polygons.max(initial=-1) else None
    if len(colours) > corners.max(initial=-1):
        of_corners = colours[corners]
    if of_corners is None:
        return Piece(points, faces, tint=tint)
    which, parted, values = split(faces, of_corners.astype(np.float64))
    return Piece(points[which], parted, values.astype(np.uint8))


def _one(colour: NDArray[np.uint8]) -> tuple[int, int, int]:
    red, green, blue = (int(part) for part in colour)
    return red, green, blue


def _strike_out(layer: Any, folder: str, places: dict[str, Path]) -> bool:
    """Removes all references from a layer but those to the package's own layers; returns whether there were any."""
    from pxr import Sdf

    found = False
    for name in layer.GetCompositionAssetDependencies():
        inside = places.get(posixpath.normpath(posixpath.join(folder, name.replace("\\", "/"))))
        found |= inside is None
        layer.UpdateCompositionAssetDependency(name, "" if inside is None else str(inside))

    def visit(path: Any) -> None:
        prim = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
        if prim is None:
            return
        for name in ("clips", "clipSets"):
            if prim.HasInfo(name):
                prim.ClearInfo(name)

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return found


def _within(indices: Integers, count: int) -> bool:
    return bool(indices.min() >= 0 and indices.max() < count)


def _parts(mesh: Any, polygons: Integers) -> Iterator[tuple[Any, Any]]:
    """(prim that is painted, which of the triangles are its): parts of the mesh by material, else all of it."""
    from pxr import UsdGeom

    left = np.ones(len(polygons), np.bool_)
    for part in UsdGeom.Subset.GetGeomSubsets(mesh, UsdGeom.Tokens.face, "materialBind"):
        own = np.isin(polygons, np.asarray(part.GetIndicesAttr().Get(), np.int64)) & left
        left &= ~own
        if own.any():
            yield part.GetPrim(), own
    if left.any():
        yield mesh.GetPrim(), left


def _values(variables: Any, names: list[str | None], columns: int) -> Array | None:
    """(N, columns) of the first of these that the mesh has."""
    for name in names:
        found = variables.GetPrimvar(name) if name else None
        if found and found.HasValue():
            values = np.asarray(found.ComputeFlattened(), np.float64)
            return values if values.ndim == 2 and values.shape[1] == columns else None
    return None
