"""Two fits of one patient in one stance at two dates: how the breasts changed, with what cannot be said."""
