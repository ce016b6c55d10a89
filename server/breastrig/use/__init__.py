"""Use cases: what `import breastrig` offers, and what command line, batch and service call.

Places and lengths are in the scan's own unit and frame, as the scanner wrote them, unless a name ends in _mm; the work
below is in metres.  Nothing here knows a server, an index or other processes.
"""
