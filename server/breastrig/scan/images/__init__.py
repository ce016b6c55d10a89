"""MR images as a clinic has them: grey values on one grid of voxels, of which the skin is made and slices are shown."""
