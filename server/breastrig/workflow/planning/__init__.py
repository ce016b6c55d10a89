"""What helps to plan on one fit while a person is at it: quick answers from what was read before."""
