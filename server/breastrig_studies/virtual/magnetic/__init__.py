"""MR images of synthetic women: where skin, nipples and a lesion are is known."""
