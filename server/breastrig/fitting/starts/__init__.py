"""Where a fit without landmarks starts: the rest pose tried all around, and on a part of a body at a few heights."""
