"""Location errors of the fitted body: 90 % radii."""
