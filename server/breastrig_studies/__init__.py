"""Evidence: a folder of scans whose truth is known, fitted in several ways, measured and tabulated."""
