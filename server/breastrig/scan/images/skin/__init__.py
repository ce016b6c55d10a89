"""The skin in an MR image, and the nipples on it."""
