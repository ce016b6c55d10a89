"""What a process that serves one scan alone keeps between its tasks."""
