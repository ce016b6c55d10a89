"""Who may sign in, as the file of users says."""
