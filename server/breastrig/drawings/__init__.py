"""The use case "transfer a drawing": from the model to the skin of a scan."""
