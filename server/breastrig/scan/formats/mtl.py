"""The materials of an OBJ: which picture each is painted with, how it is laid, and its one colour."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from breastrig.core.errors import TooLarge
from breastrig.scan.limits import MATERIAL_FILE_BYTES, MATERIALS
from breastrig.scan.pictures.companions import REMARK

# Words of a map before its file's name, and how many values follow them; those of places may have one to three.
OPTIONS = {
    **{"-blendu": 1, "-blendv": 1, "-boost": 1, "-clamp": 1, "-cc": 1, "-bm": 1, "-imfchan": 1},
    **{"-type": 1, "-texres": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3},
}
MAPS = ("map_kd", "map_ka", "map_ke")  # the picture of a scan stands behind one of them; the first has it mostly
CHANGED = (
    "A material changes its picture (option -mm or -t), which is not followed; the picture's own colours are shown."
)


@dataclass(frozen=True)
class Material:
    picture: str = ""
    scale: tuple[float, float] = (1.0, 1.0)  # of the coordinates, before the offset
    offset: tuple[float, float] = (0.0, 0.0)
    tint: tuple[int, int, int] | None = None  # sRGB
    left_out: str = ""  # a sentence


def read_materials(content: bytes) -> dict[str, Material]:
    """Materials by name, and by it without capitals.  TooLarge when there are more than of any scan."""
    words = content[:MATERIAL_FILE_BYTES].lower()
    if len(content) > MATERIAL_FILE_BYTES or max(words.count(b"newmtl"), words.count(b"map_k")) > MATERIALS:
        raise TooLarge(f"The MTL file has more than the {MATERIALS} materials allowed; join them.")
    found: dict[str, dict[str, str]] = {}
    current: dict[str, str] = {}
    for line in _decoded(content).replace("\\\n", " ").splitlines():
        word, _, rest = line.strip().replace("\t", " ").partition(" ")
        if word.lower() == "newmtl":
            current = found.setdefault(rest.strip(), {})
        elif rest.strip():
            current.setdefault(word.lower(), rest.strip())
    materials = {name: _material(lines) for name, lines in found.items()}
    bare = {REMARK.split(name)[0].rstrip(): each for name, each in reversed(materials.items())}
    return {name.casefold(): each for name, each in materials.items()} | bare | materials


def _decoded(content: bytes) -> str:
    for encoding in ("utf-8-sig", "utf-16") if content[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig",):
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    return content.decode("latin-1")


def _material(lines: dict[str, str]) -> Material:
    tint = _tint(lines.get("kd", ""))
    text = next((lines[name] for name in MAPS if name in lines), None)
    if text is None:
        return Material(tint=tint)
    words, values = deque(REMARK.split(text)[0].split()), dict[str, list[float]]()
    while words and words[0].lower() in OPTIONS:
        option = words.popleft().lower()
        most, taken = OPTIONS[option], list[float]()
        while words and len(taken) < most and (number := _number(words[0])) is not None and len(words) > 1:
            taken.append(number)
            words.popleft()
        if not taken and most == 1 and len(words) > 1:
            words.popleft()  # on, off, or the name of a channel
        values[option] = taken
    name = _tail(REMARK.split(text)[0], words)  # as it is written, for there may be several spaces in it
    changed = values.get("-mm", [0.0, 1.0]) != [0.0, 1.0] or any(values.get("-t", []))
    return Material(name, _pair(values.get("-s"), 1.0), _pair(values.get("-o"), 0.0), tint, CHANGED if changed else "")


def _tail(text: str, words: Iterable[str]) -> str:
    """The text from these last words on."""
    at = len(text)
    for word in reversed(list(words)):
        at = text.rindex(word, 0, at)
    return text[at:]


def _pair(values: list[float] | None, missing: float) -> tuple[float, float]:
    first, second = [*(values or []), missing, missing][:2]
    return first, second


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def _tint(text: str) -> tuple[int, int, int] | None:
    values = [_number(word) for word in text.split()[:3]]
    shares = [min(1.0, max(0.0, value)) for value in values if value is not None and value == value]
    if len(shares) != 3:
        return None
    red, green, blue = (round(255.0 * share) for share in shares)
    return red, green, blue
