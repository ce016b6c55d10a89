"""Drawings: read from files, made from a patient's measures, projected onto a scan, transferred to another."""
