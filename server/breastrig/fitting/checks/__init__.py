"""Which landmarks a person should check, and what that brings."""
