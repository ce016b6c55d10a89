"""One question asked of many fits a file."""
