"""Features of the skin that colour shows: areolae, navel, creases, crosses; each with its place and its error."""
