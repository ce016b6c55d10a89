"""What planned lines enclose."""
