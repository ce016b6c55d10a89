"""For whom the work at hand is done, so that shared processes can be fair between clients.

Set at the beginning of each request, in the thread that answers it.  None is the program itself.
"""

from contextvars import ContextVar

asking_client: ContextVar[str | None] = ContextVar("asking_client", default=None)
