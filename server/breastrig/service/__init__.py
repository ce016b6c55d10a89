"""The service behind HTTP: scans kept, fits run, events followed."""
