"""Files of points alone, one format a module, and the surface that is laid through them."""
