"""The public interface of `import breastrig`, on which the command line is built.

Places and lengths are in the scan's own unit and frame, as the scanner wrote them, unless a name ends in _mm; the work
below is in metres. Nothing here knows a server, a database or other processes.
"""
