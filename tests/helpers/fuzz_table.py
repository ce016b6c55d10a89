"""Counts what became of made-up files and requests; as a pytest plugin (`make fuzz`) it prints the table at the end."""

from collections import Counter, defaultdict

import pytest

COUNTS: dict[str, Counter[str]] = defaultdict(Counter)  # reader or call -> outcome -> number


def count(what: str, outcome: str) -> None:
    COUNTS[what][outcome] += 1


def lines() -> list[str]:
    """One line for each reader and call: how many cases, and how each was answered."""
    width = max(map(len, COUNTS), default=0)
    total = sum(sum(outcomes.values()) for outcomes in COUNTS.values())
    table = [
        f"{what:<{width}}{sum(outcomes.values()):>9}  "
        + ", ".join(f"{outcome} {number}" for outcome, number in sorted(outcomes.items()))
        for what, outcomes in sorted(COUNTS.items())
    ]
    return [*table, f"{'together':<{width}}{total:>9}"]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if COUNTS:
        terminalreporter.section("cases")
        for line in lines():
            terminalreporter.write_line(line)
