"""Routes of share links: making them, and what their visitors see."""
