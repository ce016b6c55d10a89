"""What lies inside the body."""
