"""Fits as DICOM objects, written or sent."""
