"""The toy rig's tube as USD, in text and as a package, for tests of what reads it."""

import io
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from helpers.toy_rig import toy_rig


def usda(
    picture: str | None = None,
    head: str = 'metersPerUnit = 1\n    upAxis = "Y"',
    more: str = "",
    colours: np.ndarray | None = None,
) -> bytes:
    """A layer with one mesh below a node that moves it by 0.25 m to the left; painted with the picture of that name."""
    rig = toy_rig()

    def rows(table: np.ndarray, form: str) -> str:
        return ", ".join("(" + ", ".join(form.format(n) for n in row) + ")" for row in table)

    counts = ", ".join(["3"] * len(rig.faces))
    lines = [
        f"int[] faceVertexCounts = [{counts}]",
        f"int[] faceVertexIndices = [{', '.join(map(str, rig.faces.ravel()))}]",
        f"point3f[] points = [{rows(rig.template, '{:.7g}')}]",
    ]
    if colours is not None:
        lines.append(f'color3f[] primvars:displayColor = [{rows(colours, "{:.6f}")}] (interpolation = "vertex")')
    if picture is not None:
        lines.append(f'texCoord2f[] primvars:st = [{rows(rig.uv, "{:.7g}")}] (interpolation = "vertex")')
        lines.append("rel material:binding = </Root/Skin>")
    material = f"""
    def Material "Skin" {{
        token outputs:surface.connect = </Root/Skin/Surface.outputs:surface>
        def Shader "Surface" {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </Root/Skin/Map.outputs:rgb>
            token outputs:surface
        }}
        def Shader "Map" {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @{picture}@
            float2 inputs:st.connect = </Root/Skin/Reader.outputs:result>
            color3f outputs:rgb
        }}
        def Shader "Reader" {{
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }}
    }}"""
    text = f"""#usda 1.0
(
    defaultPrim = "Root"
    {head}
)
def Xform "Root" {more}
{{
    double3 xformOp:translate = (0.25, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "Mustermann" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
        {chr(10).join(lines)}
    }}
    {material if picture is not None else ""}
}}
"""
    return text.encode()


def usdz(files: dict[str, bytes], packing: int = zipfile.ZIP_STORED) -> bytes:
    """A package of these files."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", packing) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return stream.getvalue()


def usd_crate(text: bytes) -> bytes:
    """The layer as Pixar's binary form."""
    from pxr import Sdf

    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text.decode())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scan.usdc"
        layer.Export(str(path))
        return path.read_bytes()
