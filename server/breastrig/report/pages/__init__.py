"""report.pdf: what its pages say, and the Typst template that sets them."""
