"""Numbers as the PDF shows them."""

from breastrig.report.row import Value

DIGITS = {"mm": 1, "ml": 0, "1": 2}  # what a scanner of 1 to 3 mm and a band of tens of ml allow


def number(value: Value | None, unit: str, *, signed: bool = False) -> str:
    """The value without its unit; a dash where there is none."""
    if value is None:
        return "-"
    text = f"{value.value:{'+' if signed else ''}.{DIGITS[unit]}f}"
    return text if float(text) else text.lstrip("+-")


def with_band(value: Value | None, unit: str) -> str:
    """290 (240 to 330)."""
    if value is None or value.low is None or value.high is None:
        return number(value, unit)
    digits = DIGITS[unit]
    return f"{number(value, unit)}  ({value.low:.{digits}f} to {value.high:.{digits}f})"
