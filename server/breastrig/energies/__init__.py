"""One residual term a file; every term has a finite-difference check in tests/energies."""
