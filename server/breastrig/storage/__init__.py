"""What survives a restart: cases, and the index that finds them.  Keeps no mathematics."""
