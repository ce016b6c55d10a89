"""Drawn lines as glTF: ribbons on the skin, alone or beside a fitted model."""
