"""The version of the package, which files and answers name."""

__version__ = "0.2.0"
