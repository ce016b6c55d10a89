"""What moves under a hand: answers from processes that are kept for the fit."""
