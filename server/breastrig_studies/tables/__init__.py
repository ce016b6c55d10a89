"""The numbers of the studies."""
