"""Who may call: tokens, sessions, origins, rates."""
