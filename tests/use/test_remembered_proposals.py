"""What tests take for proposals that were made before is what was proposed, and another scan is searched anew."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from helpers.remembered_proposals import propose_once
from helpers.remembered_uploads import FOLDER

from breastrig.use import landmarks
from breastrig.use.landmarks import ProposeJob


def test_the_same_scan_has_the_same_proposals_and_another_one_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []

    def one(job: ProposeJob) -> dict[str, Any]:
        made.append(job.units)
        return {"nipple_L": {"point": [1.0, 2.0, float(len(made))]}}

    monkeypatch.setenv(FOLDER, str(tmp_path / "remembered"))
    monkeypatch.setattr(landmarks, "propose_on_file", one)
    for name in ("scan", "copy"):
        (tmp_path / name).write_bytes(b"skin")
    job = ProposeJob(tmp_path / "scan", "ply", "mm")
    first = propose_once(job)
    assert propose_once(replace(job, scan=tmp_path / "copy")) == first
    assert propose_once(replace(job, units="m")) != first
    assert propose_once(replace(job, cuts=({"inside": True},))) != first
    job.scan.write_bytes(b"other skin")
    assert propose_once(job) != first
    assert made == ["mm", "m", "mm", "mm"]
