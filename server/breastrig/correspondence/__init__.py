"""Who matches whom: model vertices and the points of the scan."""
