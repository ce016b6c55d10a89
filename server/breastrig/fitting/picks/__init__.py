"""What a person's picks say, what the rest of the fit says of them, and which of both is followed."""
