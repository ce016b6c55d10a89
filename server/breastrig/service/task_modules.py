"""Modules that most of the service's tasks import in their processes; the fork server imports them before any task.

They are named, not imported, because a worker of a cluster needs them in its children only.
"""

TASK_MODULES = (
    "breastrig.service.fit_worker",
    "breastrig.workflow.default_model",
    "breastrig.workflow.kept.kept_scan",
    "breastrig.workflow.moving.live_pattern",
    "breastrig.workflow.lines.plan_on_fit",
    "breastrig.workflow.moving.moved_landmarks",
    "breastrig.workflow.find_ink_on_scan",
    "breastrig.workflow.propose_on_scan",
    "breastrig.workflow.read_upload",
    "breastrig.workflow.report",
    "breastrig.workflow.run_fit",
    "breastrig.workflow.run_pair",
    "breastrig.workflow.lines.transfer",
    "breastrig.workflow.share_snapshot",
)
# For rows or files on another machine: half a second to import.
REMOTE_MODULES = ("breastrig.storage.postgres", "psycopg", "breastrig.storage.places.store_files", "s3fs")
