"""Pages that certify what was done."""
