"""What the codes of a segment say that it is, in DICOM and in 3D Slicer's files, and its words as they are shown."""

from collections.abc import Iterable, Mapping, Set

from breastrig.scan.volumes.answers import TakenAs

NAME = 60  # characters of a segment's words that are shown

# Codes of concepts by their names: SNOMED CT, and the same in files of before 2018 (SRT).
ABNORMAL = {"Morphologically abnormal structure": ("49755003", "M-01000")}  # a category
ANATOMY = {"Body structure": ("123037004", "T-D000A"), "Anatomical structure": ("91723000", "T-D0005")}  # categories
WHERE = {  # types that say no more than where: a lesion may be described so as well as the body
    "Breast": ("76752008", "T-04000"),
    "Entire breast": ("181131000", "T-04009"),
    "Right breast": ("73056007", "T-04020"),
    "Left breast": ("80248007", "T-04030"),
    "Both breasts": ("63762007", "T-04080"),
    "Tissue": ("85756007", "T-D0050"),
    "Body structure": ("123037004", "T-D000A"),
    "Anatomical structure": ("91723000", "T-D0005"),
}
LESION = {  # types
    "Mass": ("4147007", "M-03000"),
    "Nodule": ("27925004", "M-03010"),
    "Lesion": ("52988006", "M-01100"),
    "Neoplasm": ("108369006", "M-8FFFF"),
    "Malignant neoplasm, primary": ("86049000", "M-80003"),
    "Neoplasm, secondary": ("14799000", "M-80006"),
    "Carcinoma": ("68453008", "M-80103"),
    "Infiltrating duct carcinoma": ("82711006", "M-85003"),
    "Ductal carcinoma in situ": ("86616005", "M-85002"),
    "Infiltrating ductal carcinoma of breast": ("408643008", "D0-F0369"),
    "Invasive lobular carcinoma": ("89740008",),
    "Lobular carcinoma in situ of breast": ("109888004",),
    "Fibroadenoma": ("65877006", "M-90100"),
    "Fibroadenoma of breast": ("254845004", "D7-F0815"),
    "Phyllodes tumor": ("71232009",),
    "Papilloma": ("711329002",),
    "Cyst": ("367643001", "M-3340A"),
    "Cyst of breast": ("399294002",),
    "Abscess": ("44132006",),
    "Hematoma": ("35566002",),
    "Breast lump": ("89164003",),
    "Gross tumor volume": ("228791009",),
}


def coded_as(categories: Set[str], types: Set[str]) -> TakenAs | None:
    """What these code values of a segment's category and type say."""
    if categories & _known(ABNORMAL) or types & _known(LESION):
        return "lesion"
    return "tissue" if categories & _known(ANATOMY) and types - _known(WHERE) else None


def _known(concepts: Mapping[str, tuple[str, ...]]) -> set[str]:
    return {code for codes in concepts.values() for code in codes}


def label_of(words: Iterable[str]) -> str:
    """The words without repeats, their printable characters, at most NAME of them."""
    text = " ".join(dict.fromkeys(word for word in words if word))
    return " ".join("".join(each if each.isprintable() else " " for each in text).split())[:NAME].strip()
