"""Colours of lines for which nobody has chosen one; each has one meaning, on the page and on paper."""

PLAN = "#101010"  # black on skin, the same for every pattern
LESION = "#f3c400"  # yellow, outlined dark; blue and red-violet stand for the patient's left and right
