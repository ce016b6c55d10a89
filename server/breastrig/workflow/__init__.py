"""Use cases from files to files: fit, pair, transfer, report.  Knows neither processes nor the index."""
