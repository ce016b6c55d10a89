"""Load: viewers, working clients, and thousands of idle and slow ones on one server, measured from outside.

`make load` prints the table.
"""
