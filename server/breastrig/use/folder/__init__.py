"""The folder of a fit: its files made, written and read back."""
