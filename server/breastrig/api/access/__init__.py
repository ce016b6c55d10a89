"""Access control: tokens, sessions, origins, rates."""
