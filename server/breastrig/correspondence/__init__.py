"""Correspondences between model vertices and points of the scan, and distances between both surfaces."""
