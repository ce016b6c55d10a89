"""What the actions of `breastrig case` do."""
