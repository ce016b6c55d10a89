"""Fits that wait, and those that run in processes of their own."""
