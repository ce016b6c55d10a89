"""The terminal: thin commands over the same code that the service runs."""
