"""What the server puts into the WSGI environ for the application, beside what the standard names.

No client can set them: headers arrive there as HTTP_... only.
"""

ADMITTED = "breastrig.admitted"  # True: the headers were checked and counted before the body was received
FORWARDED = "breastrig.forwarded"  # the trusted proxy asks; whether it said for whom
READER_GONE = "breastrig.reader_gone"  # a callable: whether nobody reads the answer any more
WAKE = "breastrig.wake"  # a callable, for any thread: a stream that gave nothing has something now
