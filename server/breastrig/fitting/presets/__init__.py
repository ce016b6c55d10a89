"""The presets that ship with the package, as data."""
