"""The rigged model: what it is, its unknowns, how it is posed, and the proof that it is sound."""
