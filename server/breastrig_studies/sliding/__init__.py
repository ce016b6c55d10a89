"""Bodies whose breasts slide on a chest wall that is known, solved apart from the cohort of `gravity`."""
