"""`breastrig serve --scheduler` as a program that is killed; it takes long: `make scale` runs it."""

from pathlib import Path

import httpx
import pytest
from helpers.installations import Large
from helpers.on_disk import kept_below
from helpers.real_server import server
from helpers.waiting import PATIENCE_S, until

from breastrig.cli.main import main

pytestmark = pytest.mark.soak

KINDS = ["started", *["iterated"] * 4, "done"]


def test_a_killed_server_is_started_again_and_purged(large: Large, model: Path, torso: bytes, tmp_path: Path) -> None:
    root = tmp_path / "data"
    options = ["--scheduler", large.cluster.address]
    log = tmp_path / "log"
    with (
        server(root, model, log, *options, FAKE_FIT="unhurried") as (process, address),
        httpx.Client(base_url=address, timeout=PATIENCE_S) as client,
    ):
        scan = client.post("/api/scans", files={"file": ("torso.ply", torso)}).json()
        wish = {"scan": scan["id"], "drawing": None}
        fits = [client.post("/api/fits", json=wish).json()["links"] for _ in range(3)]
        until(lambda: client.get(fits[1]["self"]).json()["iterations"] > 0, "a running fit")
        process.kill()
    with (
        server(root, model, log, *options, FAKE_FIT="unhurried") as (process, address),
        httpx.Client(base_url=address, timeout=PATIENCE_S) as client,
    ):
        until(lambda: all(client.get(fit["self"]).json()["state"] == "done" for fit in fits), "the ends")
        for fit in fits:
            records = client.get(fit["events"] + ".json").json()["events"]
            assert [(one["id"], one["event"]["kind"]) for one in records] == list(enumerate(KINDS, start=1))
            assert client.get(fit["result"]).status_code == 200
        assert main(["purge", "--all", "--data", str(root)]) == 2  # while a server runs
        process.terminate()
        process.wait(timeout=PATIENCE_S)
    assert scan["id"].encode() in kept_below(root)
    assert main(["purge", "--all", "--data", str(root)]) == 0
    kept = kept_below(root)
    assert not any(name.encode() in kept for name in (scan["id"], *(fit["self"].rsplit("/", 1)[1] for fit in fits)))
    assert "Traceback" not in log.read_text()
