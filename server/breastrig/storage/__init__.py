"""What survives a restart: rows in a database, files on disk.  Keeps no mathematics."""
