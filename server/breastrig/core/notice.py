"""The limits of use, written once and shown everywhere (page, files, API, command line)."""

RESEARCH_USE_ONLY = "Research use only. Not a medical device."
LIMITS_OF_USE = (
    "Research use only. Not a medical device; not for diagnosis, treatment or surgical decisions. "
    "Measurements carry scanner and fitting error."
)
