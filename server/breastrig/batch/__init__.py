"""Many fits from one table."""
