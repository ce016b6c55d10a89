"""One file format a module: bytes in, arrays out; the bytes are untrusted."""
