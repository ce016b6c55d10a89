"""A service that learns a prior: only where that was asked for, of all who are there, and of nobody who was deleted."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest
from helpers import fake_women
from helpers.waiting import ended

from breastrig.core.errors import Conflict
from breastrig.execution.limits import FitLimits
from breastrig.fitting.uncertainty.contribution import parsed_contribution
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import no_cohort
from breastrig.service.clinic_prior import PRIORS, kept_prior
from breastrig.service.service import Service
from breastrig.storage.folders import new_id
from breastrig.storage.rows.fits import NewFit
from breastrig.storage.rows.scans import ScanRow, add_scan
from breastrig.storage.storage import Storage, utc_now

FACTS = {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}
RIG = read_rig(default_rig_path())


@contextmanager
def serving(storage: Storage, learns: bool) -> Iterator[Service]:
    limits = FitLimits(workers=1, grace_s=0.1)
    service = Service(Storage(storage.root), runner=fake_women.fitted, fits=limits, keep_days=None, learn_prior=learns)
    with service.started():
        yield service


def add_woman(storage: Storage, content: bytes) -> str:
    scan_id = new_id()
    storage.folders.make(f"scans/{scan_id}")
    (storage.folders.scan(scan_id) / "scan.ply").write_bytes(content)
    add_scan(storage, ScanRow(scan_id, utc_now(), "ply", "ab" * 32, FACTS))
    return scan_id


def fit(service: Service, scan: str, stance: str = "standing") -> str:
    found = ended(service, service.add_fit(NewFit(scan=scan, stance=stance, landmarks_mm={})))
    assert found.state == "done"
    return found.id


def prior_of(*scans: bytes) -> bytes:
    prior = no_cohort(RIG)
    for scan in scans:
        sums = parsed_contribution(fake_women.body(scan), RIG, "standing")
        assert sums is not None
        prior = prior.plus(replace(prior, stances={"standing": sums}))
    return prior.content()


def given(service: Service, fit_id: str) -> bytes:
    """The prior that a fit was made with."""
    return (service.storage.folders.fit(fit_id) / fake_women.PRIOR).read_bytes()


def test_it_learns_of_those_who_are_there(storage: Storage) -> None:
    women = {content: add_woman(storage, content) for content in (b"one", b"two", b"three")}
    with serving(storage, learns=True) as service:
        first = fit(service, women[b"one"])
        fit(service, women[b"one"])  # once more: the same woman
        fit(service, women[b"two"])
        fit(service, women[b"three"])
        assert given(service, first) == b""
        service.prior.learn()
        assert kept_prior(storage, RIG.sha256) == prior_of(*women)
        assert [(each["stance"], each["women"]) for each in service.prior.stances(RIG.sha256)] == [("standing", 3)]
        assert given(service, fit(service, women[b"two"])) == prior_of(*women)
        service.delete_scan(women[b"two"])
        assert kept_prior(storage, RIG.sha256) is None
        assert service.prior.stances(RIG.sha256) == []
        service.prior.look()
        assert kept_prior(storage, RIG.sha256) == prior_of(b"one", b"three")
    with serving(storage, learns=True) as service:  # after a restart
        service.prior.look()
        assert service.prior.stances(RIG.sha256)[0]["women"] == 2


def test_nothing_is_learned_or_kept_where_nobody_asked_for_it(storage: Storage) -> None:
    scan = add_woman(storage, b"one")
    with serving(storage, learns=True) as service:
        fit(service, scan)
        service.prior.learn()
        assert kept_prior(storage, RIG.sha256) is not None
    with serving(storage, learns=False) as service:
        with pytest.raises(Conflict, match="--learn-prior"):
            service.prior.learn()
        service.prior.look()
        assert kept_prior(storage, RIG.sha256) is None
        assert (storage.root / "models" / PRIORS).read_bytes() == b""
        assert given(service, fit(service, scan)) == b""


def test_it_learns_once_a_night(storage: Storage, monkeypatch: pytest.MonkeyPatch) -> None:
    from datetime import datetime, timedelta

    from breastrig.core import wall_clock
    from breastrig.service.clinic_prior import NIGHT

    with serving(storage, learns=True) as service:
        service.prior.look()
        scan = add_woman(storage, b"one")
        fit(service, scan)
        learned = []
        monkeypatch.setattr(service.prior, "_learn", lambda: learned.append(wall_clock.now()))
        midnight = datetime.now().astimezone().replace(hour=0, minute=30) + timedelta(days=1)
        for hours in range(24):
            monkeypatch.setattr(wall_clock, "now", lambda hours=hours: midnight + timedelta(hours=hours))
            service.prior.look()
        assert [each.hour for each in learned] == [NIGHT]
