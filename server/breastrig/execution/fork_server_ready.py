"""What the fork server imports last: it looks which libraries its children will have, so that they need not."""

from breastrig.execution.one_thread import look_for_libraries

look_for_libraries()
