"""The audit log of a data folder: who opened, changed, exported, shared or deleted what, without any content."""
