"""Files that a scan names: materials, pictures and buffers beside it, in its folder or its zip.

Programs write their names in many ways: quoted, with %20, back slashes, folders of another computer, other case, other
letters for the same accents.  A name is looked up by its whole path first, then by its last part, never outside.
"""

import os
import re
import unicodedata
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property, partial
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from breastrig.scan.pictures.texture import LEFT_OUT, TURNED, is_turned, plain_picture

PICTURES = ("jpg", "jpeg", "jpe", "jfif", "png", "webp", "tif", "tiff", "bmp", "tga", "gif", "avif")
REMARK = re.compile(r"\s#")  # behind a name, if it is no part of it
LOOKED_THROUGH = 100  # folders within that of a scan
MISSING = "A picture that the scan names is not beside it, and the scan is shown without it."
NO_MATERIAL = "The material file that the scan names is not beside it; colours may be missing."
ONLY_PICTURE = "The scan does not name its picture; the only one beside it was used."
ONLY_MATERIAL = "The scan names no material file that is there; the only one beside it was used."
ONLY_PAINTING = "The scan does not say which material it is painted with; the only one with a picture was used."
OTHER_ENDING = "A picture that the scan names is beside it with another ending, and was used."
UNNAMED = (
    "The scan says where a picture lies on it but not which, and none stands alone beside it; it is shown without."
)
UNPLACED = "The scan names a picture but not where it lies on the skin, and is shown without it."

Reader = Callable[[], bytes]


class Companions:
    """The files that one scan may name, read on demand; `notes` says what was missing or changed."""

    def __init__(self, listed: Callable[[], Mapping[str, Reader]] = dict) -> None:
        self._listed = listed
        self._notes: dict[str, None] = {}
        self._pictures: dict[str, bytes | None] = {}

    @cached_property
    def _files(self) -> dict[str, Reader]:
        return {_usual(name): read for name, read in self._listed().items()}

    def note(self, sentence: str) -> None:
        """Adds a note on these files, unless it was given already."""
        self._notes[sentence] = None

    def notes(self) -> tuple[str, ...]:
        """Notes on these files, one sentence each."""
        return tuple(self._notes)

    def find(self, written: str) -> bytes | None:
        """The file of this name as it is written in the scan; None when there is none."""
        place = self._place(written)
        return None if place is None else self._files[place]()

    def material(self, written: str) -> list[bytes]:
        """The material files of this name, or of these names with spaces between, or the only one."""
        one = self._place(written) or self._place(REMARK.split(written)[0])
        found = [one] if one is not None else [self._place(word) for word in written.split()]
        places = [place for place in found if place is not None]
        if not places:
            places = list(self._ending_in(("mtl",)))
            if len(places) != 1:
                if written or places:
                    self.note(NO_MATERIAL)
                return []
            self.note(ONLY_MATERIAL)
        return [self._files[place]() for place in places]

    def picture(self, written: str) -> bytes | None:
        """The JPEG or PNG of this name, without anything but its pixels.  TooLarge when it has too many."""
        place = self._place(written) or self._other_ending(written)
        if place is None:
            self.note(MISSING)
            return None
        if self._place(written) is None:
            self.note(OTHER_ENDING)
        return self._picture(place)

    def has_picture(self, written: str) -> bool:
        """Whether `picture` finds a file of this name, readable or not."""
        return (self._place(written) or self._other_ending(written)) is not None

    def _other_ending(self, written: str) -> str | None:
        """The only picture of this name with another ending."""
        stem = PurePosixPath(_usual(written)).stem
        alike = [each for each in self._ending_in(PICTURES) if PurePosixPath(each).stem == stem]
        return alike[0] if len(alike) == 1 else None

    def only_picture(self) -> bytes | None:
        """The picture beside a scan that names none; None unless there is just one."""
        places = [place for place in self._ending_in(PICTURES) if "/" not in place]
        if len(places) != 1:
            if not self._notes.keys() - {NO_MATERIAL}:
                self.note(UNNAMED)
            return None
        self.note(ONLY_PICTURE)
        return self._picture(places[0])

    def _picture(self, place: str) -> bytes | None:
        if place not in self._pictures:
            content = self._files[place]()
            self._pictures[place] = plain_picture(content)
            if self._pictures[place] is None:
                self.note(LEFT_OUT)
            elif is_turned(content):
                self.note(TURNED)
        return self._pictures[place]

    def _ending_in(self, endings: tuple[str, ...]) -> Iterator[str]:
        return (place for place in self._files if PurePosixPath(place).suffix.removeprefix(".") in endings)

    def _place(self, written: str) -> str | None:
        """The path of this file: as it is written, else the least deep of the same last part."""
        for name in dict.fromkeys((_usual(written), _usual(unquote(written)))):
            if name in self._files:
                return name
            last = name.rsplit("/", 1)[-1]
            alike = [place for place in self._files if place.rsplit("/", 1)[-1] == last]
            if last and alike:
                return min(alike, key=lambda place: (place.count("/"), place))
        return None


def _usual(name: str) -> str:
    """A path in canonical spelling: composed accents, lower case, slashes; no quotes, drives or .. parts."""
    plain = unicodedata.normalize("NFC", name).casefold().strip().strip("\"'").strip().replace("\\", "/")
    parts = [part.strip() for part in plain.split("/")]
    return "/".join(part for part in parts if part not in ("", ".", "..") and not part.endswith(":"))


def beside(scan: Path, read: Callable[[Path], bytes]) -> Companions:
    """The files in the folder of a scan and in those within it; links are left out."""

    def listed() -> dict[str, Reader]:
        own, folders = _entries(scan.parent)
        for folder in folders[:LOOKED_THROUGH]:
            own += _entries(folder)[0]
        return {path.relative_to(scan.parent).as_posix(): partial(read, path) for path in own}

    return Companions(listed)


def _entries(folder: Path) -> tuple[list[Path], list[Path]]:
    """The ordinary files and the folders in it; none where it may not be looked into."""
    files, folders = [], []
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_file(follow_symlinks=False):
                files.append(folder / entry.name)
            elif entry.is_dir(follow_symlinks=False) and not entry.name.startswith("."):
                folders.append(folder / entry.name)
    return sorted(files), sorted(folders)
