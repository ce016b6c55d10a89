"""What of a pattern can be dragged on the skin: each handle stands for one parameter and says its value at a place."""
