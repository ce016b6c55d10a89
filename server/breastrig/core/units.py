"""Units of length at the door of the program; inside, everything is in metres."""

METRES_PER_UNIT = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254}
UNIT_NAMES = {"m": "metres", "dm": "decimetres", "cm": "centimetres", "mm": "millimetres", "in": "inches"}
UNIT_CHOICES = ("auto", *METRES_PER_UNIT)
