"""Runs make's targets side by side: `python run_targets.py MAKE TARGET...`; fails when one of them fails.

None of `make test`'s parts keeps all cores at work: each waits, for a server, for a browser's next frame, for its last
test.  Together they do.  The last target is the one that waits for what it sees, the browser's: the others give way to
it, so that it is hardly slower than alone, on a slow machine too.  What they print is not mixed up: the first target's
lines come as they are printed, the next one's as soon as that has ended, and so on.  All are seen to their end, for who
mends one wants to know of all.
"""

import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from typing import IO

LOOK_EVERY_S = 0.2
NICE = 5  # of all targets but the last: three of their processes count as one of its


def show(target: str, process: subprocess.Popen[bytes], log: IO[bytes]) -> None:
    """Copies what the target has printed and prints, until it ends."""
    print(f"\n== {target}", flush=True)
    has_ended = False
    while not has_ended:
        has_ended = process.poll() is not None  # what it printed last is there now
        sys.stdout.buffer.write(log.read())
        sys.stdout.flush()
        if not has_ended:
            time.sleep(LOOK_EVERY_S)


def main(make: str, *targets: str) -> int:
    """The exit code: 0 when all targets were made, 130 after Ctrl-C, which every target gets as well."""
    environment = {name: value for name, value in os.environ.items() if name != "MAKELEVEL"}  # says where it is, else
    with ExitStack() as stack:
        running = {}
        try:  # Ctrl-C may come while they are being started
            for target in targets:
                file = stack.enter_context(tempfile.NamedTemporaryFile(prefix="breastrig-make-"))
                process = subprocess.Popen(
                    ["nice", "-n", str(NICE if target != targets[-1] else 0), make, target],
                    env=environment,
                    stdin=subprocess.DEVNULL,
                    stdout=file,
                    stderr=subprocess.STDOUT,
                )
                running[target] = stack.enter_context(process), stack.enter_context(open(file.name, "rb"))
            for target, (process, log) in running.items():
                show(target, process, log)
        except KeyboardInterrupt:
            return 130
        failed = [target for target, (process, _) in running.items() if process.returncode != 0]
    print(f"\n== {'failed: ' + ', '.join(failed) if failed else 'all passed: ' + ', '.join(targets)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
