"""The functions of this room that a service has executed in other processes.

Each is imported where it is called: a server that only hands them on is spared the numerics, which take longer to
import than all else that it needs.  Their parameters are in jobs.py.
"""

from functools import partial
from pkgutil import resolve_name
from typing import Any

MODULES = ["breastrig.use.default_model"]  # that the tasks need, to be imported in their processes beforehand


def call(name: str, *given: Any) -> Any:
    """The result of the function `module:name`."""
    return resolve_name(name)(*given)


def _task(name: str) -> partial[Any]:
    MODULES.append(f"breastrig.use.{name.partition(':')[0]}")
    return partial(call, f"breastrig.use.{name}")


keeping = _task("steps.kept_scan:keeping")
read_upload = _task("read_upload:read_upload")
propose_on_file = _task("propose_on_scan:propose_on_file")
find_ink_on_file = _task("lines.find_ink_on_scan:find_ink_on_file")
run_fit = _task("run_fit:run_fit")
run_prediction = _task("predictions.run_prediction:run_prediction")
check_lines_on_skin = _task("lines.lines_on_skin:check_lines_on_skin")
transfer = _task("lines.transfer_lines:transfer")
checks_on_fit = _task("lines.checks_on_fit:checks_on_fit")
plan_on_fit = _task("lines.plan_on_fit:plan_on_fit")
live_pattern = _task("moving.live_pattern:live_pattern")
read_and_live_pattern = _task("moving.live_pattern:read_and_live_pattern")
moved_landmarks = _task("moving.moved_landmarks:moved_landmarks")
follow_landmarks = _task("moving.moved_landmarks:follow_landmarks")
report_pdf_of = _task("reports.report:report_pdf_of")
measures_json_of = _task("reports.report:measures_json_of")
volume_vtu_of = _task("reports.volume:volume_vtu_of")
write_snapshot = _task("reports.share_snapshot:write_snapshot")
