"""Files that an evaluation writes: tables, figures, pictures and the summary."""
