"""Routes for what is planned on the skin while it is being planned: answers that nobody stores."""
