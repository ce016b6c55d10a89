"""Commands of those who answer for a data folder: its audit log, backups."""
