"""Reading and writing the rows, one table a module."""
