"""Values that the calls of this room return: a fit, a drawing, a model, pictures."""
