"""What moves under a hand: the tasks of processes that are kept for one fit."""
