"""The hospital's own file of who a code is: read where objects are made, never kept, and nothing of it in a message."""

import csv
import io
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import date
from pathlib import Path

from pydicom.config import RAISE
from pydicom.valuerep import validate_value

from breastrig.core.errors import BadInput
from breastrig.core.private_files import read_ordinary

FILE_BYTES = 20_000_000  # some hundred thousand patients
VRS = {"id": "LO", "name": "PN", "sex": "CS", "accession": "SH"}  # value representations
SEXES = ("", "F", "M", "O")


@dataclass(frozen=True)
class Patient:
    """Whose the objects are, as DICOM writes it."""

    id: str
    name: str = ""  # Family^Given; other scripts after =
    birth_date: str = ""  # YYYY-MM-DD
    sex: str = ""  # F, M or O
    accession: str = ""  # number of the order
    is_code: bool = False  # id is a code that only the hospital's own file turns into a person


def patient_of(code: str, file: Path | None) -> Patient:
    """The patient of a code by the hospital's file; without one the code itself is the PatientID.

    The file is CSV with a header (code, id; name, birth_date, sex, accession where they are known), or TOML with a
    table [CODE] for each patient.  BadInput for one that cannot be used, and for a code that it does not name once.
    """
    if file is None:
        return _checked({"id": code, "name": code.translate(str.maketrans("^=", "  "))}, "This code", is_code=True)
    try:
        text = read_ordinary(file, FILE_BYTES).decode("utf-8-sig")
        rows = _toml(text) if file.suffix.lower() == ".toml" else _csv(text)
    except OSError as error:
        raise BadInput(f"The file of identities cannot be read ({error.strerror or 'no ordinary file'}).") from error
    except (ValueError, csv.Error) as error:  # not UTF-8, or no TOML
        raise BadInput("The file of identities is neither CSV nor TOML in UTF-8; save it so.") from error
    found = [(where, row) for where, row in rows if row.get("code") == code]
    if len(found) != 1:
        raise BadInput(
            f"The file of identities names the code {code} {len(found) or 'not even'} times; it must name it once."
            if found
            else f"The file of identities does not name the code {code}; add it there, or leave the file out."
        )
    where, row = found[0]
    return _checked({name: text for name, text in row.items() if name != "code"}, where)


def _csv(text: str) -> list[tuple[str, Mapping[str, str]]]:
    header = text.partition("\n")[0]
    table = csv.DictReader(io.StringIO(text), delimiter=";" if ";" in header else ",", strict=True)
    if not {"code", "id"} <= {*(table.fieldnames or ())}:
        raise BadInput("The file of identities has no columns code and id in its first line.")
    return [
        (f"Line {table.line_num} of the file of identities", {k: (v or "").strip() for k, v in row.items() if k})
        for row in table
    ]


def _toml(text: str) -> list[tuple[str, Mapping[str, str]]]:
    return [
        ("The file of identities", {"code": code} | {key: str(value).strip() for key, value in row.items()})
        for code, row in tomllib.loads(text).items()
        if isinstance(row, dict)
    ]


def _checked(row: Mapping[str, str], where: str, is_code: bool = False) -> Patient:
    """BadInput names the field, never its contents."""
    known = {each.name for each in fields(Patient)} - {"is_code"}
    if not row.get("id"):
        raise BadInput(f"{where}: there is no id, which every DICOM object needs.")
    for name, value in row.items():
        try:
            if name == "birth_date":
                bool(value) and date.fromisoformat(value)
            elif name in VRS:
                validate_value(VRS[name], value, RAISE)
                if name == "sex" and value not in SEXES:
                    raise ValueError
        except ValueError as error:
            rule = {"birth_date": "YYYY-MM-DD", "sex": "F, M or O", "accession": "at most 16 characters"}
            said = rule.get(name, "at most 64 characters, no backslash")
            raise BadInput(f"{where}: {name} does not fit into a DICOM object; write {said}.") from error
    return Patient(**{name: value for name, value in row.items() if name in known}, is_code=is_code)
