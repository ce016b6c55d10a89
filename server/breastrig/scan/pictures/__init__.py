"""Pictures of scans, and the other files that a scan names."""
