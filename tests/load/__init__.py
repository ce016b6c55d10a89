"""Load: many viewers and some working clients on one server, measured from outside; `make load` prints the table."""
