"""The meshes of USDZ and USD files, by Pixar's own library; runs in a process of its own (usd_process.py).

A USD layer can name other layers and files anywhere, which the library would open.  So only the package's first layer
is read, as one that has no place, and all that it names beyond itself is struck out before anything is composed.
Pictures are taken from the package by their names.  The library reads files and no bytes: the one layer lies in a
private folder meanwhile.
"""

import io
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.core.scratch import scratch_folder
from breastrig.scan.formats.texture import LEFT_OUT, TURNED, is_turned, plain_picture
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE, TRIANGLES, USD_PRIMS, VERTICES, ZIP_ENTRIES
from breastrig.scan.piece import Piece, Pieces

CRATE = b"PXR-USDC"
PICTURES = (".png", ".jpg", ".jpeg")
DAMAGED = "This USD file is damaged, or holds nothing that can be read here; export the scan as GLB, PLY or OBJ."
NESTED = "This USD file keeps its mesh in other layers; open it in the page, or export the scan as GLB, PLY or OBJ."


def usd_pieces(data: bytes, texture: bool) -> Pieces:
    """What the scene draws, in metres and with +Y up.  BadScan or TooLarge with a sentence."""
    from pxr import UsdUtils

    silent = UsdUtils.CoalescingDiagnosticDelegate()  # its warnings name what is in the file
    try:
        layer, files = _opened(data)
        return _Scene(layer, files, texture).pieces()
    except BadInput:
        raise
    except MemoryError as error:
        raise TooLarge("Reading this scan needs more memory than there is; simplify it first.") from error
    except Exception as error:  # a parser of untrusted bytes can raise anything
        raise BadScan(DAMAGED) from error
    finally:
        del silent


def _opened(data: bytes) -> tuple[bytes, dict[str, bytes]]:
    """The first layer, and the package's pictures by their names."""
    if not data.startswith(b"PK"):
        return data, {}
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as package:
            entries = package.infolist()
            if len(entries) > ZIP_ENTRIES:
                raise TooLarge(f"This USDZ holds {len(entries):,} files, more than the {ZIP_ENTRIES:,} allowed.")
            if any(entry.compress_type != zipfile.ZIP_STORED for entry in entries):
                raise BadScan("This USDZ is compressed, which the format does not allow; export it again.")
            wanted = [entry for entry in entries if PurePosixPath(entry.filename.lower()).suffix in PICTURES]
            if sum(entry.file_size for entry in (entries[0], *wanted)) > FILE_BYTES:
                raise TooLarge(f"This USDZ unpacks to more than the {FILE_BYTES // MEBIBYTE} MB allowed.")
            return package.read(entries[0]), {entry.filename: package.read(entry) for entry in wanted}
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError) as error:
        raise BadScan(DAMAGED) from error


class _Scene:
    """What one layer draws by itself."""

    def __init__(self, content: bytes, files: dict[str, bytes], texture: bool) -> None:
        from pxr import Sdf, Usd, UsdGeom

        with scratch_folder() as folder:
            path = folder / ("scan.usdc" if content.startswith(CRATE) else "scan.usda")
            path.write_bytes(content)
            layer = Sdf.Layer.OpenAsAnonymous(str(path))
            if layer is None:
                raise ValueError("no layer")
            alone = Sdf.Layer.CreateAnonymous()
            alone.TransferContent(layer)  # into memory: the file goes
            del layer
        self._is_nested = _strike_out(alone)
        self._stage = Usd.Stage.Open(alone)
        self._files, self._texture = files, texture
        self._notes: list[str] = []
        self._pictures: dict[str, bytes | None] = {}
        self._places = UsdGeom.XformCache()
        self._metres = UsdGeom.GetStageMetersPerUnit(self._stage)
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
                    raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")
                pieces.append(piece)
        if not pieces:
            raise BadScan(NESTED if self._is_nested else DAMAGED)
        return Pieces(tuple(pieces), False, tuple(dict.fromkeys(self._notes)))

    def _mesh(self, mesh: Any) -> Iterator[Piece]:
        """One piece for each material."""
        points = np.asarray(mesh.GetPointsAttr().Get(), np.float64).reshape(-1, 3)
        counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get(), np.int64).ravel()
        indices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get(), np.int64).ravel()
        if (counts < 0).any() or counts.sum() != len(indices) or (len(indices) and not _within(indices, len(points))):
            raise ValueError("its polygons name vertices that do not exist")
        corners, polygons = _fans(counts)
        if mesh.GetOrientationAttr().Get() == "leftHanded":
            corners = corners[:, ::-1]
        matrix = np.array(self._places.GetLocalToWorldTransform(mesh.GetPrim()), np.float64)
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            corners = corners[:, ::-1]
        placed = self._metres * (points @ matrix[:3, :3] + matrix[3, :3])
        if self._has_z_up:
            placed = np.column_stack([placed[:, 0], placed[:, 2], -placed[:, 1]])
        faces = indices[corners] if len(corners) else np.zeros((0, 3), np.int64)
        for prim, own in _parts(mesh, polygons):
            yield self._piece(prim, mesh, placed, faces[own], corners[own])

    def _piece(self, prim: Any, mesh: Any, points: Array, faces: Integers, corners: Integers) -> Piece:
        from pxr import UsdGeom

        variables = UsdGeom.PrimvarsAPI(mesh)
        picture, name = self._painted(prim) if self._texture else (None, None)
        if picture is not None:
            uv = _values(variables, [name, "st", "st0", "UVMap"], 2)
            if uv is not None and len(uv) == len(points):
                return Piece(points, faces, uv=uv, picture=picture)
            if uv is not None and len(uv) > corners.max(initial=-1):  # one for each corner: split there
                split = np.arange(3 * len(faces)).reshape(-1, 3)
                return Piece(points[faces.ravel()], split, uv=uv[corners.ravel()], picture=picture)
        linear = _values(variables, ["displayColor"], 3)
        if linear is None or len(linear) != len(points):
            return Piece(points, faces)
        light = np.clip(np.nan_to_num(linear), 0.0, 1.0)
        srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
        return Piece(points, faces, np.asarray(np.round(255.0 * srgb).astype(np.uint8)))

    def _painted(self, prim: Any) -> tuple[bytes | None, str | None]:
        """(picture, name of its coordinates) of what the prim is painted with."""
        from pxr import UsdShade

        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        surface = material.ComputeSurfaceSource()[0] if material else None
        colour = surface.GetInput("diffuseColor") if surface else None
        sources = colour.GetConnectedSources()[0] if colour else []
        if not sources:
            return None, None
        shader = UsdShade.Shader(sources[0].source.GetPrim())
        asked = shader.GetInput("file").Get() if shader.GetInput("file") else None
        if asked is None:
            return None, None
        reader = shader.GetInput("st").GetConnectedSources()[0] if shader.GetInput("st") else []
        name = UsdShade.Shader(reader[0].source.GetPrim()).GetInput("varname") if reader else None
        return self._picture(str(asked.path)), str(name.Get()) if name else None

    def _picture(self, path: str) -> bytes | None:
        plain = PurePosixPath(path.replace("\\", "/")).name.lower()
        if plain not in self._pictures:
            found = next(
                (data for name, data in self._files.items() if PurePosixPath(name.lower()).name == plain), None
            )
            picture = None if found is None else plain_picture(found)
            if picture is None:
                self._notes.append(LEFT_OUT)
            elif found is not None and is_turned(found):
                self._notes.append(TURNED)
            self._pictures[plain] = picture
        return self._pictures[plain]


def _strike_out(layer: Any) -> bool:
    """Leaves nothing in a layer that names another; whether there was any."""
    from pxr import Sdf

    found = [bool(layer.subLayerPaths)]
    layer.subLayerPaths.clear()

    def visit(path: Any) -> None:
        prim = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
        if prim is None:
            return
        for name in ("references", "payload", "clips", "clipSets"):
            if prim.HasInfo(name):
                found.append(True)
                prim.ClearInfo(name)

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return any(found)


def _fans(counts: Integers) -> tuple[Integers, Integers]:
    """(F, 3) corners, counted through all polygons, of their triangles; and (F,) the polygon of each."""
    fans = np.maximum(counts - 2, 0)
    polygons = np.repeat(np.arange(len(counts)), fans)
    first = (np.cumsum(counts) - counts)[polygons]
    step = np.arange(len(polygons)) - np.repeat(np.cumsum(fans) - fans, fans)
    return np.column_stack([first, first + step + 1, first + step + 2]), polygons


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
