"""A cohort of breasts solved under gravity, and what is estimated on it."""
