"""The proof that a rig is sound."""
