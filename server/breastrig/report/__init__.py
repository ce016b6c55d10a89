"""The use case "measure": how far the fitted model is from the scan and from the picked landmarks."""
