"""`make load`, or `python -m load --seconds 60 --clients 4 --viewers 50 --idle 2000` with tests/ on the path."""

import argparse
import os
import platform
import sys

from load.measured import slow_table, table
from load.run import run
from load.share_readers import run_share_readers
from load.slow import SlowClients

if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="load", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--clients", type=int, default=4)
    parser.add_argument("--viewers", type=int, default=50)
    parser.add_argument("--idle", type=int, default=2000, help="connections on which nothing happens")
    parser.add_argument("--slow-headers", type=int, default=200)
    parser.add_argument("--slow-bodies", type=int, default=200)
    parser.add_argument("--slow-readers", type=int, default=200)
    parser.add_argument("--triangles", type=int, default=2_000_000, help="of the scan that is read through a link")
    options = parser.parse_args()
    slow = SlowClients(options.idle, options.slow_headers, options.slow_bodies, options.slow_readers)
    found = run(options.seconds, options.clients, options.viewers, slow)
    out = sys.stdout.write
    out(f"{options.clients} clients, {options.viewers} viewers; Python {platform.python_version()}, ")
    out(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n\n")
    out("\n".join(table(found.measured, found.seconds)) + "\n\n")
    out("\n".join(slow_table(found.slow)) + "\n\n")
    out(f"{'server after':<16}{'its memory MB':>14}{'all MB':>10}{'threads':>10}{'processes':>11}\n")
    last = len(found.memory) - 1
    for index in sorted({0, last // 4, last // 2, 3 * last // 4, last}):
        at, used = found.memory[index]
        out(f"{at:>12.0f} s  {used.server_mb:>14.0f}{used.tree_mb:>10.0f}{used.threads:>10}{used.processes:>11}\n")
    out(f"\nthe server ended with {found.exit_status}, its log has {len(found.log.splitlines())} lines\n")
    out("".join(f"  {line[:300]}\n" for line in found.log.splitlines()[-5:]))
    shared = run_share_readers(options.triangles)
    out("\n" + "\n".join(shared.table()) + "\n")
    sys.exit(1 if found.measured.errors or found.exit_status or shared.errors else 0)
