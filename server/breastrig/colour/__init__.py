"""Detects features in a scan's colours: the surgeon's ink, areolae, creases. Used only for scans with colour."""
