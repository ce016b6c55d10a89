"""Documents of cases as the service reads and writes them, found through the index; one kind a module."""
