"""What guides the pen on the skin: a template on paper, in true size."""
