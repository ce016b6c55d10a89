"""The index of a data folder: it finds cases, scans and fits, and is made again from their folders when it is lost."""
