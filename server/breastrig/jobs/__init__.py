"""Running work: one fit as a stream of events, and the processes that carry it."""
