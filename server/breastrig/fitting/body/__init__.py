"""Prior statistics of bodies: joint distribution of the model's scales and shapes."""
