"""Events of fits: stored before anyone sees them, replayed from any number, waited for."""
