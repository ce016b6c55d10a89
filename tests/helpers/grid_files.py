"""NRRD and MetaImage files, byte by byte, of the labels of `label_maps` or of any other numbers."""

import gzip
import zlib
from collections.abc import Mapping, Sequence

import numpy as np

from helpers.label_maps import LOW, SIZES, to_ras

NRRD_TYPES = {"u1": "unsigned char", "i2": "short", "u2": "uint16", "f4": "float", "f8": "double"}
META_TYPES = {"u1": "MET_UCHAR", "i2": "MET_SHORT", "u2": "MET_USHORT", "f4": "MET_FLOAT", "f8": "MET_DOUBLE"}


def to_lps(low: np.ndarray = LOW, sizes: np.ndarray = SIZES) -> np.ndarray:
    return np.asarray(np.diag([-1.0, -1.0, 1.0, 1.0]) @ to_ras(low, sizes))


def nrrd_fields(values: np.ndarray, affine: np.ndarray | None = None, encoding: str = "gzip") -> dict[str, str]:
    """The fields of a header, the affine (LPS) of the last three axes; to be changed by a test."""
    affine = to_lps() if affine is None else affine
    order = {"<": "little", ">": "big", "|": "little", "=": "little"}[values.dtype.byteorder]
    vectors = ["({})".format(",".join(repr(float(each)) for each in column)) for column in affine[:3, :4].T]
    lists = values.ndim - 3
    return {
        "type": NRRD_TYPES[values.dtype.str[1:]],
        "dimension": str(values.ndim),
        "space": "left-posterior-superior",
        "sizes": " ".join(map(str, values.shape)),
        "space directions": " ".join(["none"] * lists + vectors[:3]),
        "kinds": " ".join(["list"] * lists + ["domain"] * 3),
        "endian": order,
        "encoding": encoding,
        "space origin": vectors[3],
    }


def nrrd(values: np.ndarray, fields: Mapping[str, str] | None = None, words: Mapping[str, str] | None = None) -> bytes:
    """The file; `values` (..., I, J, K), fields as of `nrrd_fields`, `words` its keys with values."""
    fields = nrrd_fields(values) if fields is None else fields
    lines = ["NRRD0005", "# Complete NRRD file format specification at:"]
    lines += [f"{name}: {value}" for name, value in fields.items()]
    lines += [f"{name}:={value}" for name, value in (words or {}).items()]
    content = values.tobytes(order="F")
    return "\n".join([*lines, "", ""]).encode() + (
        gzip.compress(content, 1) if fields["encoding"] == "gzip" else content
    )


def slicer_words(segments: Sequence[tuple[str, int, int, str, str]]) -> dict[str, str]:
    """What 3D Slicer writes of segments: name, layer, label, and SCHEME^CODE^MEANING of category and type."""
    words = {"Segmentation_MasterRepresentation": "Binary labelmap"}
    for at, (name, layer, label, category, kind) in enumerate(segments):
        words |= {
            f"Segment{at}_ID": f"Segment_{at + 1}",
            f"Segment{at}_Name": name,
            f"Segment{at}_Layer": str(layer),
            f"Segment{at}_LabelValue": str(label),
            f"Segment{at}_Tags": "Segmentation.Status:inprogress|TerminologyEntry:Segmentation category and type - "
            f"3D Slicer General Anatomy list~{category}~{kind}~^^~Anatomic codes - DICOM master list~^^~^^|",
        }
    return words


def meta_fields(values: np.ndarray, affine: np.ndarray | None = None, came_from: str = "RAI") -> dict[str, str]:
    """The fields of a header as ITK writes it; `came_from` are the sides where its axes begin."""
    affine = to_lps() if affine is None else affine
    steps = np.linalg.norm(affine[:3, :3], axis=0)
    numbers = {
        "TransformMatrix": (affine[:3, :3] / steps).T.ravel(),
        "Offset": affine[:3, 3],
        "CenterOfRotation": np.zeros(3),
        "ElementSpacing": steps,
    }
    shown = {name: " ".join(repr(float(each)) for each in listed) for name, listed in numbers.items()}
    return {
        "ObjectType": "Image",
        "NDims": "3",
        "BinaryData": "True",
        "BinaryDataByteOrderMSB": str(values.dtype.byteorder == ">"),
        "CompressedData": "True",
        **shown,
        "AnatomicalOrientation": came_from,
        "DimSize": " ".join(map(str, values.shape)),
        "ElementType": META_TYPES[values.dtype.str[1:]],
        "ElementDataFile": "LOCAL",
    }


def meta_image(values: np.ndarray, fields: Mapping[str, str] | None = None) -> bytes:
    fields = meta_fields(values) if fields is None else fields
    content = values.tobytes(order="F")
    header = "".join(f"{name} = {value}\n" for name, value in fields.items()).encode()
    return header + (zlib.compress(content) if fields["CompressedData"] == "True" else content)
