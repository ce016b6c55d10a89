"""Units of length of input and output; inside the program, everything is in metres."""

METRES_PER_UNIT = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
UNIT_NAMES = {
    **{"m": "metres", "dm": "decimetres", "cm": "centimetres", "mm": "millimetres"},
    **{"in": "inches", "ft": "feet"},
}
UNIT_CHOICES = ("auto", *METRES_PER_UNIT)
BEYOND = 1e9  # in any unit; a coordinate that is larger is a mistake, and its square still a number


def distance_text(metres: float) -> str:
    """A distance for a sentence, in millimetres up to the size at which such numbers are readable."""
    if metres < 10.0:
        return f"{1e3 * metres:.0f} mm"
    return f"{metres:,.0f} m" if metres < 1e6 else "more than 1,000 km"
