"""One file format a module: bytes in, arrays out; hostile until proven otherwise."""
