"""Formats log lines: for people, or one JSON object each for programs. They name no patient.

Ids of fits are random and die with the fit; names of files, addresses and landmarks are never logged.
"""

import json
import logging
import os
import sys
from datetime import UTC, datetime

VARIABLE = "BREASTRIG_LOG"  # for the worker processes, which inherit the environment
TEXT = "%(asctime)s %(levelname)s %(name)s: %(message)s"
FIELDS = "fields"  # name in a record's `extra` of what a JSON line says in members of their own
NOISY = ("uvicorn", "asyncio", "trimesh", "PIL")  # they log files' contents, or nothing of use


class JsonLines(logging.Formatter):
    """Log lines as JSON objects: time (UTC), level, logger, message, and the traceback where there is one."""

    def format(self, record: logging.LogRecord) -> str:
        moment = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        line = {
            "time": moment.replace("+00:00", "Z"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "process": record.process,
        }
        line |= getattr(record, FIELDS, {})
        if record.exc_info:
            line["traceback"] = self.formatException(record.exc_info)
        return json.dumps(line, ensure_ascii=False)


class TextLines(logging.Formatter):
    """Log lines for people."""

    def format(self, record: logging.LogRecord) -> str:
        traceback = getattr(record, FIELDS, {}).get("traceback")  # one that was made fit to be logged
        return super().format(record) if traceback is None else f"{super().format(record)}\n{traceback}"


def set_up_logs(form: str) -> None:
    """Sends this process's log to stderr as text or json; auto is text on a terminal and json elsewhere."""
    if form == "auto":
        form = "text" if sys.stderr.isatty() else "json"
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines() if form == "json" else TextLines(TEXT))
    logging.basicConfig(level=logging.INFO, handlers=[handler])
    for noisy in NOISY:
        logging.getLogger(noisy).setLevel(logging.ERROR)
    os.environ[VARIABLE] = form


def set_up_logs_from_environment() -> None:
    """Sets up the log of a worker process, as its server called set_up_logs."""
    form = os.environ.get(VARIABLE)
    if form is not None and not logging.getLogger().handlers:
        set_up_logs(form)
