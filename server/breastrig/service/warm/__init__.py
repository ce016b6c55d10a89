"""Scans in work: the process that has read an upload stays for it a while, and proposes and fits there."""
