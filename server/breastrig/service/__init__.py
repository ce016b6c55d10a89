"""What the HTTP floor needs done: scans kept, fits run, events followed."""
