"""What guides the pen on the skin, of a fit and its plan."""
