"""What a scan's colours show: the surgeon's ink, areolae, creases.  Scans without colour never come here."""
