"""What the form of a scan's skin shows of landmarks: dents and folds, found near where a fit expects them."""
