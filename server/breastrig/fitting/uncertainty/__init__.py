"""How far off the fitted body may be: radii that hold the true place with 90 %."""
