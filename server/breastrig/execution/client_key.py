"""For whom the work at hand is done, so that shared processes can be fair between clients.

Set at the beginning of each request, in the thread that answers it.  None is the program itself.
"""

from contextvars import ContextVar

client_key: ContextVar[str | None] = ContextVar("client_key", default=None)
