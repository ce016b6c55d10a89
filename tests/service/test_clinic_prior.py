"""A service that learns a prior: only where that was asked for, of all who are there, and of nobody who was deleted."""

import pytest
from helpers import fake_women
from helpers.fake_women import add_woman, fit, serving

from breastrig.core.errors import Conflict
from breastrig.fitting.uncertainty.contribution import parsed_contribution
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import cohort_of_scans
from breastrig.service.clinic_prior import PRIORS, kept_prior
from breastrig.service.service import Service
from breastrig.storage.storage import Storage

RIG = read_rig(default_rig_path())


def prior_of(*scans: bytes) -> bytes:
    found = [(str(scan), "standing", parsed_contribution(fake_women.body(scan), RIG, "standing")) for scan in scans]
    return cohort_of_scans(RIG, found).content()


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
        assert [(each["stance"], each["patients"]) for each in service.prior.stances(RIG.sha256)] == [("standing", 3)]
        assert given(service, fit(service, women[b"two"])) == prior_of(*women)
        service.delete_scan(women[b"two"])
        assert kept_prior(storage, RIG.sha256) is None
        assert service.prior.stances(RIG.sha256) == []
        service.prior.look()
        assert kept_prior(storage, RIG.sha256) == prior_of(b"one", b"three")
    with serving(storage, learns=True) as service:  # after a restart
        service.prior.look()
        assert service.prior.stances(RIG.sha256)[0]["patients"] == 2


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
