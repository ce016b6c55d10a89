"""A data folder in one encrypted file, and back."""
