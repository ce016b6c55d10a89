"""What a fitted body measures, as numbers, pictures, tables and sheets."""
