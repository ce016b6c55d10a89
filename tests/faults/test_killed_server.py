"""A server that is killed while fits run, again and again on one data folder: every fit keeps or gets an honest end."""

import json
import os
import random
import sqlite3
import threading
from collections import Counter
from pathlib import Path
from typing import Any

import httpx
import pytest
from helpers.real_server import server
from helpers.waiting import until

from breastrig.jobs.carry_out import ATTEMPTS, TOO_OFTEN

KILLS = int(os.environ.get("BREASTRIG_KILLS", "3"))
SEED = 5
FILES = ("result", "fitted_glb", "fitted_ply", "drawing", "distances")


def kept(client: httpx.Client, links: dict[str, str]) -> dict[str, bytes]:
    """All that a finished fit shows: its story and its files."""
    answers = {name: client.get(links[name]) for name in FILES} | {"story": client.get(links["events"] + ".json")}
    assert {answer.status_code for answer in answers.values()} == {200}
    return {name: answer.content for name, answer in answers.items()}


def ask_until_dead(client: httpx.Client, scan_id: str, fits: dict[str, dict[str, Any]], seen: dict[str, Any]) -> None:
    """Asks for fits and looks at them; what was promised is in `fits`, what was seen done in `seen`."""
    try:
        for _ in range(6):
            answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None}).json()
            fits[answer["id"]] = answer["links"]
            for fit_id in list(fits)[-6:]:
                if fit_id not in seen and client.get(fits[fit_id]["self"]).json()["state"] == "done":
                    seen[fit_id] = kept(client, fits[fit_id])
        while True:
            client.get("/healthz")
    except (httpx.TransportError, json.JSONDecodeError):
        return


def wait_for_ends(client: httpx.Client, fits: dict[str, dict[str, Any]]) -> None:
    """Returns when every fit has ended; as long as one ends in time, the others may take longer."""
    open_fits = set(fits)

    def ended(fit_id: str) -> bool:
        return client.get(fits[fit_id]["self"]).json()["state"] in ("done", "failed")

    def some_ended() -> bool:
        before = len(open_fits)
        open_fits.difference_update([fit_id for fit_id in open_fits if ended(fit_id)])
        return len(open_fits) < before

    while open_fits:
        until(some_ended, f"the end of one of {len(open_fits)} fits")


def checked_end(client: httpx.Client, links: dict[str, str]) -> str:
    """The fit's state, after a look at whether its story and files agree with it."""
    fit = client.get(links["self"]).json()
    records = client.get(links["events"] + ".json?limit=1000").json()["events"]
    assert [one["id"] for one in records] == list(range(1, fit["last_event"] + 1))
    kinds = [one["event"]["kind"] for one in records]
    if fit["state"] == "done":
        assert kinds == ["started", *["iterated"] * 4, "done"]
        assert json.loads(kept(client, links)["result"]) == records[-1]["event"]["result"]
    else:  # begun as often as it may be
        assert (fit["state"], fit["reason"], kinds[-1]) == ("failed", TOO_OFTEN.format(ATTEMPTS), "failed")
        assert kinds[:-1] == ["started", *["iterated"] * 4][: len(kinds) - 1]
        assert client.get(links["result"]).status_code == 409
    return str(fit["state"])


@pytest.mark.skipif(KILLS < 1, reason="BREASTRIG_KILLS=0")
def test_no_fit_is_lost_or_left_open_whenever_the_server_is_killed(
    tmp_path: Path, model: Path, torso: bytes, note
) -> None:
    data, log, chance = tmp_path / "data", tmp_path / "log", random.Random(SEED)
    fits: dict[str, dict[str, Any]] = {}
    seen: dict[str, dict[str, bytes]] = {}
    scan_id, moment_s = "", 0.0
    for kill in range(KILLS + 1):
        with (
            server(data, model, log, FAKE_FIT="unhurried") as (process, address),
            httpx.Client(base_url=address, timeout=20) as client,
        ):
            wait_for_ends(client, fits)
            ends = {fit_id: checked_end(client, links) for fit_id, links in fits.items()}
            for fit_id, before in seen.items():
                assert kept(client, fits[fit_id]) == before
            seen |= {fit_id: kept(client, fits[fit_id]) for fit_id, end in ends.items() if end == "done"}
            if kill:
                note(f"server killed, {kill}: {moment_s:.2f} s after the first fit", str(dict(Counter(ends.values()))))
            if kill == KILLS:
                break
            if not scan_id:
                scan_id = client.post("/api/scans", files={"file": ("torso.ply", torso)}).json()["id"]
            moment_s = chance.uniform(0.02, 1.2)
            timer = threading.Timer(moment_s, process.kill)
            timer.start()
            ask_until_dead(client, scan_id, fits, seen)
            timer.join()
            process.wait()
    assert len(fits) >= KILLS
    rows = sqlite3.connect(data / "breastrig.sqlite3")
    try:
        assert rows.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        known = {row[0] for row in rows.execute("SELECT id FROM fits")}
    finally:
        rows.close()
    assert set(fits) <= known
    assert {folder.name for folder in (data / "fits").iterdir()} == known
    assert "Traceback" not in log.read_text()
