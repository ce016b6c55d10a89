"""What two visits of one patient show, against bodies that changed by a known amount between them."""
