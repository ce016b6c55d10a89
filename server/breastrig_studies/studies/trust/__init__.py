"""What a fit says of itself: its radii, its doubts and its verdict."""
