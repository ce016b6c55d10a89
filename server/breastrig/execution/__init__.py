"""Tasks in other processes: this machine's or a cluster's.  Knows nothing of bodies."""
