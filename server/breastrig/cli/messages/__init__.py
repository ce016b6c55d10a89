"""What several commands say while they work, and of what they read."""
