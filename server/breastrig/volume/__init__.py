"""The inside of a fitted body: chest wall and tetrahedra, and what is computed on them."""
