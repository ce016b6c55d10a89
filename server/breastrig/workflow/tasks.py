"""The functions of this room that a service has executed in other processes, without the numerics that they import.

Their parameters are in jobs.py.
"""

from breastrig.core.late_function import LateFunction

read_upload = LateFunction("breastrig.workflow.read_upload", "read_upload")
propose_on_file = LateFunction("breastrig.workflow.propose_on_scan", "propose_on_file")
find_ink_on_file = LateFunction("breastrig.workflow.find_ink_on_scan", "find_ink_on_file")
keeping = LateFunction("breastrig.workflow.kept.kept_scan", "keeping")
run_fit = LateFunction("breastrig.workflow.run_fit", "run_fit")
run_pair = LateFunction("breastrig.workflow.run_pair", "run_pair")
transfer = LateFunction("breastrig.workflow.lines.transfer", "transfer")
plan_on_fit = LateFunction("breastrig.workflow.lines.plan_on_fit", "plan_on_fit")
live_pattern = LateFunction("breastrig.workflow.moving.live_pattern", "live_pattern")
read_and_live_pattern = LateFunction("breastrig.workflow.moving.live_pattern", "read_and_live_pattern")
moved_landmarks = LateFunction("breastrig.workflow.moving.moved_landmarks", "moved_landmarks")
follow_landmarks = LateFunction("breastrig.workflow.moving.moved_landmarks", "follow_landmarks")
report_pdf_of = LateFunction("breastrig.workflow.report", "report_pdf_of")
measures_json_of = LateFunction("breastrig.workflow.report", "measures_json_of")
write_snapshot = LateFunction("breastrig.workflow.share_snapshot", "write_snapshot")
