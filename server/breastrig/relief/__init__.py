"""Detects landmarks in the form of a scan's skin: dents and folds near where a fit expects them."""
