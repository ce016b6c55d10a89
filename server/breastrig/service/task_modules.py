"""Names of modules that the fork server imports before any task; a cluster's worker needs them in its children."""

TASK_MODULES = (
    "breastrig.service.fits.fit_worker",
    "breastrig.audit.certificate",
    "breastrig.use.default_model",  # which also makes the model ready
    *(
        f"breastrig.use.{name}"
        for name in (
            "archive.objects",
            "cases.visits",
            "guides.template",
            "ink",
            "landmarks",
            "transfer",
            "volume",
            "lines.checks_on_fit",
            "lines.lines_on_skin",
            "lines.plan_on_fit",
            "marks.propose_marks",
            "moving.live_pattern",
            "moving.moved_landmarks",
            "reports.share_snapshot",
            "visits.over_time",
        )
    ),
    "scipy.interpolate",  # which reports need
)
