"""The use case "fit": from a scan and a rig to a stream of frozen iterates."""
