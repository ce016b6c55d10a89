"""Documents that leave the program, each as one model for writing, reading and serving."""
