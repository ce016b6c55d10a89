"""A server that is killed while fits run, again and again on one data folder: every fit keeps or gets an honest end."""

import json
import os
import random
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from helpers.fault_table import FILES, all_fits, outcome, wait_for_ends
from helpers.real_server import server, starting
from helpers.waiting import PATIENCE_S

from breastrig.cases.fits import ATTEMPTS, TOO_OFTEN

pytestmark = pytest.mark.soak

KILLS = int(os.environ.get("BREASTRIG_KILLS", "2"))
SEED = 5
ASKED = 4  # fits before each kill: some run, some wait, some may be done
EARLY = 5  # each so many kills one comes while the server starts

Links = dict[str, str]
Seen = dict[str, dict[str, bytes]]


def kept(client: httpx.Client, links: Links) -> dict[str, bytes]:
    """All that a finished fit shows: its events and its files."""
    answers = {name: client.get(links[name]) for name in FILES} | {"events": client.get(links["events"] + ".json")}
    assert {answer.status_code for answer in answers.values()} == {200}
    return {name: answer.content for name, answer in answers.items()}


def ask_until_dead(
    client: httpx.Client, scan_id: str, fits: dict[str, Links], seen: dict[str, dict[str, bytes]]
) -> None:
    """Asks for fits and looks at them; what was promised is in `fits`, what was seen done in `seen`."""
    try:
        for _ in range(ASKED):
            answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None}).json()
            fits[answer["id"]] = answer["links"]
        while True:
            for fit_id in list(fits)[-2 * ASKED :]:
                if fit_id not in seen and client.get(fits[fit_id]["self"]).json()["state"] == "done":
                    seen[fit_id] = kept(client, fits[fit_id])
            client.get("/healthz")
    except (httpx.TransportError, json.JSONDecodeError):
        return


@contextmanager
def killed_after(process: subprocess.Popen[str], seconds: float) -> Iterator[None]:
    timer = threading.Timer(seconds, process.kill)
    timer.start()
    try:
        yield
    finally:
        timer.join()
        process.wait()


@pytest.mark.skipif(KILLS < 1, reason="BREASTRIG_KILLS=0")
def test_no_fit_is_lost_or_left_open_whenever_the_server_is_killed(
    tmp_path: Path, model: Path, torso: bytes, note
) -> None:
    """Half of the kills hit fits that were hit before."""
    data, log, chance = tmp_path / "data", tmp_path / "log", random.Random(SEED)
    fits: dict[str, Links] = {}
    since: list[str] = []  # fits of the kills that the next line of the table is about
    what: list[str] = []
    seen: Seen = {}
    scan_id = ""
    for kill in range(KILLS + 1):
        if kill % EARLY == EARLY - 1:
            moment_s = chance.uniform(0.1, 2.0)
            with starting(data, model, log, FAKE_FIT="unhurried") as process, killed_after(process, moment_s):
                pass
            what.append(f"{moment_s:.2f} s after its start")
        with (
            server(data, model, log, FAKE_FIT="unhurried") as (process, address),
            httpx.Client(base_url=address, timeout=2 * PATIENCE_S) as client,
        ):
            if kill % 2 == 0 or kill == KILLS:
                wait_for_ends(client, since, log)
                for fit_id, before in seen.items():
                    assert kept(client, fits[fit_id]) == before
                if what:
                    note(f"server killed {' and '.join(what)}", outcome(client, data, since))
                check_reasons(client, [fits[fit_id] for fit_id in since])
                since, what = [], []
            if kill == KILLS:
                break
            if not scan_id:
                scan_id = client.post("/api/scans", files={"file": ("torso.ply", torso)}).json()["id"]
            moment_s = chance.uniform(0.02, 1.5)
            known = set(fits)
            with killed_after(process, moment_s):
                ask_until_dead(client, scan_id, fits, seen)
            since += [fit_id for fit_id in fits if fit_id not in known]
            what.append(f"{moment_s:.2f} s")
    assert len(fits) >= KILLS
    assert all_fits(data) >= set(fits)
    assert "Traceback" not in log.read_text()


def check_reasons(client: httpx.Client, fits: list[Links]) -> None:
    """The one reason to fail here is to have been begun as often as may be."""
    for links in fits:
        fit = client.get(links["self"]).json()
        if fit["state"] == "failed":
            assert fit["reason"] == TOO_OFTEN.format(ATTEMPTS)
