"""Lines that were drawn with a marker on the skin, read from a scan's colours."""
