"""The manifest of a batch: a CSV table with one scan a row, checked whole before anything runs.

A mistake in row 9,000 of a table that runs for hours is found in its first second.  Each wrong row is one sentence
with its line in the file.
"""

import csv
import io
import re
import unicodedata
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from breastrig.core.errors import BadInput, BadSettings, BreastRigError, unknown_name
from breastrig.core.private_files import is_folder, is_ordinary, read_ordinary, shown
from breastrig.core.stances import STANCES
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.patterns import asked_drawing, tumour_text
from breastrig.fitting.recipe import load_recipe
from breastrig.rig.model import Rig
from breastrig.scan.landmarks.landmark_files import landmarks_of_file
from breastrig.scan.true_size import length_of
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers, checked_answers, segments_of_words
from breastrig.use.steps.prepare import check_prior, checked_picks, named_drawing
from breastrig.use.steps.settings import FIRST, FitSettings

VOLUME_COLUMNS = ("frame", "segments", "series", "lesions", "same_place")  # as options of `breastrig fit`
BETWEEN_FILES = "|"  # names of files may hold blanks
COLUMNS = (
    *("scan", "landmarks", "length", "name", "units", "stance", "preset", "drawing", "tumour", "refine"),
    *VOLUME_COLUMNS,
)
YES_NO = {"": True, "no": False, "false": False, "0": False, "yes": True, "true": True, "1": True}
MANIFEST_BYTES = 100_000_000  # half a million long rows
NAME_BYTES = 200  # file systems take 255, and a folder that is being written has a longer name
INPUTS = "inputs.json"  # in each result: what it was made from
INPUTS_SCHEMA = "breastrig/batch-inputs@1"


class BadManifest(BadInput):
    """A table that cannot be used; `faults` has a sentence for each wrong row."""

    def __init__(self, faults: list[str]) -> None:
        super().__init__(" ".join(faults))
        self.faults = faults

    def __reduce__(self) -> tuple[type["BadManifest"], tuple[list[str]]]:
        return BadManifest, (self.faults,)


@dataclass(frozen=True)
class BatchRow:
    """One fit, checked as far as it can be without reading the scan."""

    name: str  # of the folder of its result
    scan: Path
    landmarks: Path | None
    units: str
    settings: FitSettings
    answers: VolumeAnswers = NOTHING_SAID  # of a volume
    lesions: tuple[Path, ...] = ()  # files of lesions that lie in the image

    @property
    def preset_file(self) -> Path | None:
        """A preset of the user's own."""
        preset = str(self.settings.preset)
        return Path(preset) if preset.endswith(".toml") else None


def read_manifest(
    file: Path, rig: Rig, out: Path, force: bool = False, prior: Path | None = None
) -> tuple[BatchRow, ...]:
    """The rows of a table in UTF-8, split by commas, semicolons or tabs; paths are relative to the table.

    `out` is where the results will be; `force` lets them go beside what no batch has made; `prior` is that of all
    rows.  Raises BadManifest.
    """
    rows, faults = [], []
    lines: dict[str, int] = {}  # name -> line

    @cache  # the same few words in thousands of rows
    def check_preset(preset: str) -> None:
        check_prior(load_recipe(preset), prior)

    for number, (line, cells) in enumerate(_cells(file), start=1):
        try:
            row = _row(cells, number, file.parent, rig, check_preset)
            key = unicodedata.normalize("NFC", row.name).casefold()  # some file systems see no difference
            if key in lines:
                raise BadInput(f'The name "{row.name}" is also that of line {lines[key]}; give each row its own.')
            lines[key] = line
            _check_place(out / row.name, force)
        except BreastRigError as error:
            faults.append(f"{file.name}, line {line}: {error}")
        else:
            rows.append(row)
    if not rows and not faults:
        faults = [f"{file.name} has no rows."]
    if faults:
        raise BadManifest(faults)
    return tuple(rows)


def _cells(file: Path) -> Iterator[tuple[int, Mapping[str, str]]]:
    """(line, column -> stripped text) of each row that is not blank."""
    text = _text(file)
    head = text.split("\n", 1)[0]
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=max(",;\t", key=head.count), strict=True)
    try:
        columns = [name.strip().lower() for name in next(reader, [])]
        faults = [f"{file.name}: {unknown_name('column', name, COLUMNS)}" for name in columns if name not in COLUMNS]
        faults += [f"{file.name}: The column {name} is there twice." for name in COLUMNS if columns.count(name) > 1]
        if not faults and "scan" not in columns:
            faults = [f"{file.name} has no column scan; its first line must name the columns, as in: scan,landmarks."]
        if faults:
            raise BadManifest(faults)
        for values in reader:
            if not any(value.strip() for value in values):
                continue
            if len(values) > len(columns):
                raise BadManifest(
                    [
                        f"{file.name}, line {reader.line_num}: {len(values)} values for {len(columns)} columns; "
                        'put a value that holds a comma into "quotes".'
                    ]
                )
            yield reader.line_num, dict(zip(columns, (value.strip() for value in values), strict=False))
    except csv.Error as error:
        raise BadManifest(
            [
                f"{file.name}, line {reader.line_num}: This is no table ({error}).",
            ]
        ) from error


def _text(file: Path) -> str:
    try:
        content = read_ordinary(file, MANIFEST_BYTES)
        if len(content) > MANIFEST_BYTES:
            raise BadManifest([f"{file.name} is larger than {MANIFEST_BYTES // 10**6} MB; split it."])
        return content.decode("utf-8-sig")
    except OSError as error:
        raise BadManifest([f"The manifest {shown(file)} cannot be read ({error.strerror}); check the name."]) from error
    except UnicodeDecodeError as error:
        raise BadManifest([f"{file.name} is no text in UTF-8; save the table as CSV (UTF-8)."]) from error


def _row(
    cells: Mapping[str, str], number: int, base: Path, rig: Rig, check_preset: Callable[[str], object]
) -> BatchRow:
    """Raises a BreastRigError with what is wrong in it."""
    if not cells.get("scan"):
        raise BadInput("There is no scan in this row.")
    scan = base / cells["scan"]
    scan = scan if is_folder(scan) else _file(base, cells["scan"], "scan")
    landmarks = _file(base, cells["landmarks"], "landmark file") if cells.get("landmarks") else None
    length = length_of(_words(cells["length"])) if cells.get("length") else None
    if landmarks is not None:
        checked_picks(rig, landmarks_of_file(landmarks, lambda: (1e-3, (np.zeros(3), np.zeros(3)))))
    elif length is not None:
        raise BadInput("A length is between landmarks or marks, and this row names no landmark file.")
    preset = cells.get("preset") or "default"
    if preset.endswith(".toml"):
        preset = str(_file(base, preset, "preset"))
    check_preset(preset)
    drawing = named_drawing(rig, _drawing(cells))
    if drawing is not None:
        asked_drawing(rig, drawing)
    return BatchRow(
        name=_name(cells.get("name") or f"{number:04d}-{scan.stem}"),
        scan=scan,
        landmarks=landmarks,
        units=_one_of("unit", cells.get("units") or "auto", ("auto", *METRES_PER_UNIT)),
        settings=FitSettings(
            stance=_one_of("stance", cells.get("stance") or "auto", STANCES),
            preset=preset,
            drawing=drawing,
            refine=YES_NO[_one_of("value of refine", cells.get("refine", "").lower(), tuple(YES_NO))],
            length=length,
        ),
        answers=checked_answers(
            cells.get("frame"),
            segments_of_words(cells.get("segments", "").split()),
            cells.get("series"),
            same_place=cells.get("same_place") or None,
        ),
        lesions=tuple(_file(base, each, "file of lesions") for each in _words(cells.get("lesions", ""))),
    )


def _words(cell: str) -> list[str]:
    """The names of files in a cell."""
    return [word for each in cell.split(BETWEEN_FILES) if (word := each.strip())]


def _file(base: Path, text: str, what: str) -> Path:
    file = base / text
    if not is_ordinary(file):
        raise BadInput(f"There is no {what} {shown(text)}; paths are relative to the manifest.")
    return file


def _one_of(what: str, word: str, known: tuple[str, ...]) -> str:
    if word not in known:
        raise BadSettings(unknown_name(what, word, tuple(filter(None, known))))
    return word


def _drawing(cells: Mapping[str, str]) -> str | None:
    """The column drawing, and the tumours of the column beside it, split by blanks."""
    asked = cells.get("drawing") or FIRST
    parts = [] if asked == "none" else [asked]
    return "+".join([*parts, *(tumour_text(short) for short in cells.get("tumour", "").split())]) or None


def _name(text: str) -> str:
    """The name; refused where it is no plain name of a folder."""
    if text.startswith(".") or re.search(r"[/\\\x00-\x1f\x7f]", text) or text.endswith((".", " ")):
        raise BadInput(f'"{text}" cannot be the name of a folder here; use no slash, and no dot at its ends.')
    if len(text.encode()) > NAME_BYTES or text.casefold() == "batch.csv":
        raise BadInput(f'"{text[:40]}" cannot be the name of a folder here; choose another name.')
    return text


def _check_place(folder: Path, force: bool) -> None:
    """Raises BadInput for an existing result that no batch has made."""
    made = folder.is_dir() and (force or (folder / INPUTS).is_file())
    if folder.is_symlink() or (folder.exists() and not made):
        raise BadInput(f"{folder} is there already and is no result of a batch; choose another name, or remove it.")
