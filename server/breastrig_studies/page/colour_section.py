"""Landmarks from colour on the page: the answer in words."""

from breastrig_studies.page.section import Section, mm
from breastrig_studies.tables.table import Row, Table


def colour_section(landmarks: Table, areolae: Table | None) -> Section:
    """What colour brings to proposed landmarks, and the areolae's diameters."""
    answers = []
    for row in landmarks.rows:
        number = _by_name(landmarks, row)
        if number["landmark"] == "nipple":
            coloured, p95, form = (mm(_float(number[name])) for name in ("coloured_mm", "p95_mm", "form_mm"))
            answers.append(
                f"Nipples are proposed within {coloured} (95 %: {p95}) where the form alone gives {form}; left and "
                f"right are exchanged on {number['exchanged']} scans."
            )
    for row in [] if areolae is None else areolae.rows:
        number = _by_name(areolae, row) if areolae is not None else {}
        if row.mean and number["bias_mm"] is not None:
            answers.append(
                f"Diameters of areolae are off by {_float(number['bias_mm']):+.1f} mm in the mean, with a deviation of "
                f"{mm(_float(number['deviation_mm']))}."
            )
    return Section(
        "colour_landmarks",
        "What do colours say of the landmarks?",
        "Areolae are looked for near the place that the form of the body expects, on painted virtual skins: "
        "photographs of real skin may give other numbers. What is not seen, covered or reconstructed, stays with the "
        "form.",
        tuple(answers),
        (),
        ("colour_landmarks", *(("areolae",) if areolae is not None else ())),
    )


def _by_name(table: Table, row: Row) -> dict[str, str | int | float | None]:
    return dict(zip((column.name for column in table.columns), row.cells, strict=True))


def _float(cell: str | int | float | None) -> float:
    return float(cell or 0.0)
