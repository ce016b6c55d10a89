"""Detects the kind of a file from its bytes; its name only words the errors."""

import re

from breastrig.core.errors import BadScan
from breastrig.scan.point_clouds.point_table import is_point_table

FILE_TYPES = {  # a kind of content -> its files' endings; the only list of them, which the service tells its page
    "ply": (".ply",),
    "obj": (".obj",),
    "stl": (".stl",),
    "glb": (".glb",),
    "gltf": (".gltf",),
    "zip": (".zip",),
    "usd": (".usdz", ".usd", ".usda", ".usdc"),
    "off": (".off",),
    "3mf": (".3mf",),
    "nifti": (".nii", ".nii.gz", ".gz"),  # volumes, as the next
    "nrrd": (".nrrd",),
    "mha": (".mha", ".mhd"),
    "dicom": (".dcm",),
    "pcd": (".pcd",),  # points, as the next
    "xyz": (".xyz", ".asc", ".pts", ".txt", ".csv", ".xyzn", ".xyzrgb"),
}
VOLUMES = ("nifti", "nrrd", "mha", "dicom")
ENDINGS = tuple(ending for endings in FILE_TYPES.values() for ending in endings)
UNKNOWN = "unknown"  # the type of a file whose name says nothing
USD_LAYERS = (".usd", ".usda", ".usdc")
USD_STARTS = (b"PXR-USDC", b"#usda")
BINARY_STL_HEADER = 84  # bytes: a title and the number of triangles
BINARY_STL_TRIANGLE = 50  # bytes
NIFTI_1_MARK_AT, DICOM_MARK_AT = 344, 128
DICOM_MARK = b"DICM"
SEGMENTATIONS = (
    "1.2.840.10008.5.1.4.1.1.66.4",
    "1.2.840.10008.5.1.4.1.1.66.7",
)  # classes of DICOM; also as a label map
STRUCTURES = "1.2.840.10008.5.1.4.1.1.481.3"
DICOM_START = re.compile(rb"(?:\x02|\x08)\x00.\x00(?:AE|AS|CS|DA|DT|IS|LO|LT|OB|PN|SH|SQ|ST|TM|UI|UL|UN|US)", re.DOTALL)
DICOM_ELEMENT = 8  # bytes before its value, where kinds of values are not written
META_IMAGE_START = re.compile(rb"\s*(?:ObjectType|NDims|Comment)\s*=", re.IGNORECASE)
LOOKED_AT = 4096  # bytes in which a text file shows what it is
PCD_START = re.compile(rb"^(?:\s*#[^\n]*\n|\s*\n)*\s*(?:VERSION|FIELDS|COLUMNS)\s", re.IGNORECASE)
# Geomview's keyword: with places in a picture, colours, normals, more dimensions; remarks may stand before it.
OFF_START = re.compile(
    rb"(?:\s*#[^\r\n]*[\r\n])*\s*(?:ST)?(?P<colours>C)?(?P<normals>N)?(?P<more>4n?|n)?(?:OFF|off)(?=\s|$)"
)
THREE_MF = b"http://schemas.microsoft.com/3dmanufacturing/"  # namespace of a 3MF's model
UTF_8_MARK, UTF_16_MARKS = b"\xef\xbb\xbf", (b"\xff\xfe", b"\xfe\xff")
ANALYZE = (b"\x5c\x01\0\0", b"\0\0\x01\x5c")  # the header's own length, 348
EXPORT_MAP = "export the segmentation as NIfTI (.nii.gz) or as DICOM SEG"
EXPORT = "export the scan as PLY, OBJ, STL or GLB"


def file_type_of(data: bytes, named: str | None = None) -> str:
    """The file type, one of FILE_TYPES; BadScan with a sentence for any other content.

    `named` is the file name's ending. It decides only for a binary STL of the wrong length, which has no mark of its
    own, and words the errors.
    """
    start = data[:LOOKED_AT]
    named = (named or "").lower().lstrip(".")
    if not data:
        raise BadScan(f"The file is empty; {EXPORT}.")
    if start.startswith(b"glTF"):
        return "glb"
    if re.match(rb"ply\s*[\r\n]", start):
        return "ply"
    if start.startswith(USD_STARTS) or _is_usdz(start):
        return "usd"
    if start.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        return "zip"
    if _is_nifti(start):
        return "nifti"
    if start.startswith(b"NRRD"):
        return "nrrd"
    if _is_meta_image(start):
        return "mha"
    if is_dicom(start):
        return "dicom"
    if (other := other_volume(start)) is not None:
        raise BadScan(other)
    if is_binary_stl(data) or is_text_stl(data):
        return "stl"
    if OFF_START.match(start):
        return "off"
    if THREE_MF in start and start.lstrip(UTF_8_MARK).lstrip().startswith(b"<"):
        return "3mf"
    if PCD_START.match(start):
        return "pcd"
    if re.match(rb"\s*\{", start) and b'"asset"' in data:
        return "gltf"
    if b"\0" not in start and re.search(rb"(?:^|[\r\n])[ \t]*v[ \t]+[-+.\d]", data):
        return "obj"
    if b"\0" not in start and is_point_table(start):
        return "xyz"
    if b"\0" in start and (named == "stl" or _is_nearly_binary_stl(data)):
        return "stl"
    if named in FILE_TYPES:
        raise BadScan(f"This file is named .{named} but holds no {named.upper()} data; {EXPORT}.")
    raise BadScan(
        "This file is no 3D scan that can be read; give PLY, OBJ, STL, GLB, glTF, USDZ, OFF, 3MF, PCD, a table of "
        "points, a label map (NIfTI, NRRD, MetaImage, DICOM SEG), or a zip of one of them."
    )


def volume_kind(start: bytes) -> str:
    """The kind of volume in these first bytes: "label map", "structures" (contours), "dicom", "other" or "" (none)."""
    if _is_nifti(start) or start.startswith(b"NRRD") or _is_meta_image(start):
        return "label map"
    if is_dicom(start):
        segmentation = any(each.encode() in start for each in SEGMENTATIONS)
        return "label map" if segmentation else "structures" if STRUCTURES.encode() in start else "dicom"
    return "" if other_volume(start) is None else "other"


def _is_nifti(start: bytes) -> bool:
    return start[NIFTI_1_MARK_AT : NIFTI_1_MARK_AT + 4] == b"n+1\0" or start[4:8] == b"n+2\0"


def _is_meta_image(start: bytes) -> bool:
    return META_IMAGE_START.match(start) is not None and (b"ElementType" in start or b"DimSize" in start)


def is_dicom(start: bytes) -> bool:
    """Whether it begins as DICOM, with the preamble of files or without it."""
    if start[DICOM_MARK_AT : DICOM_MARK_AT + 4] == DICOM_MARK or start.startswith(DICOM_MARK):
        return True
    if DICOM_START.match(start):
        return True
    if not start.startswith(b"\x08\x00"):
        return False
    second = DICOM_ELEMENT + int.from_bytes(start[4:DICOM_ELEMENT], "little")
    return start[second : second + 2] == b"\x08\x00"


def other_volume(start: bytes) -> str | None:
    """The error sentence for unsupported kinds of volumes; None for any other file."""
    if start[NIFTI_1_MARK_AT : NIFTI_1_MARK_AT + 4] == b"ni1\0" or start[4:8] == b"ni2\0":
        return "This is half of a NIfTI file (.hdr or .img); export both as one file, .nii or .nii.gz."
    if start[:4] in ANALYZE and len(start) == 348:
        return f"This is half of an Analyze file (.hdr and .img), which does not say which side is left; {EXPORT_MAP}."
    return None


def plain_text(data: bytes) -> bytes:
    """Text in UTF-8 without a mark before it, of a file that begins with one; all other bytes as they are."""
    if data.startswith(UTF_8_MARK):
        return data[len(UTF_8_MARK) :]
    if data.startswith(UTF_16_MARKS):
        return data.decode("utf-16", "replace").encode()
    return data


def is_text_stl(data: bytes) -> bool:
    """Whether it begins with a solid and its facets; a binary one may have the word in its title."""
    start = data[:LOOKED_AT]
    return bool(re.match(rb"\s*solid\b", start, re.IGNORECASE)) and b"facet" in start.lower() and b"\0" not in start


def is_binary_stl(data: bytes) -> bool:
    """Whether the length is just what the number of triangles asks for."""
    return _bytes_over_binary_stl(data) == 0


def _is_nearly_binary_stl(data: bytes) -> bool:
    """Whether a few bytes follow the triangles."""
    return 0 <= _bytes_over_binary_stl(data) < BINARY_STL_TRIANGLE < len(data) - BINARY_STL_HEADER


def _bytes_over_binary_stl(data: bytes) -> int:
    """Bytes beyond those that the announced triangles need; negative where the file is shorter or announces none."""
    if len(data) < BINARY_STL_HEADER:
        return -1
    count = int.from_bytes(data[BINARY_STL_HEADER - 4 : BINARY_STL_HEADER], "little")
    return len(data) - BINARY_STL_HEADER - BINARY_STL_TRIANGLE * count


def _is_usdz(start: bytes) -> bool:
    """Whether a zip's first file is a layer of USD, as the format of its packages wants it."""
    length = int.from_bytes(start[26:28], "little")
    return start.startswith(b"PK\x03\x04") and start[30 : 30 + length].decode("latin-1").lower().endswith(USD_LAYERS)
