"""Whether a finished fit may be believed: its signals, and what they say together."""
