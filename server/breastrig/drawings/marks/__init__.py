"""Small marks that two scans share."""
