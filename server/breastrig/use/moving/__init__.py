"""Interactive tasks (dragged landmarks and patterns), of processes that are kept for one fit."""
