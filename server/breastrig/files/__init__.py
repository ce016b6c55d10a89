"""Documents that leave the program, as one model each: for whoever writes, reads or serves them."""
