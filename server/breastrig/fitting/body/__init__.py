"""What is known of bodies: how the model's scales and shapes go together in them."""
