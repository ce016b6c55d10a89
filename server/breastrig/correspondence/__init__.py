"""Who matches whom, model vertices and the points of the scan, and how far both are apart."""
