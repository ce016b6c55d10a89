"""How far two drawings of the same names are apart, and a picture of both."""
