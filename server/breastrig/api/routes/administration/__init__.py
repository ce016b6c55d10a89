"""For those who answer for the service."""
