"""What became of every fit after a fault, looked at from outside: over HTTP, and in the data folder."""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import httpx

from breastrig.cases import layout
from breastrig.cases.writing import PART
from helpers.waiting import PATIENCE_S, until

FILES = ("result", "fitted_glb", "fitted_ply", "drawing", "distances")


@dataclass(frozen=True)
class Outcome:
    """Numbers of fits, and of files that belong to none."""

    asked: int
    done: int
    resumed: int  # begun again after their worker or server was gone, whatever came of it
    failed: int  # with a sentence that says why
    lost: int  # promised, and now unknown or without an end
    doubled: int  # with two beginnings, two ends or an iteration told twice
    left_over: int

    @property
    def nothing_is_wrong(self) -> bool:
        return (self.lost, self.doubled, self.left_over) == (0, 0, 0)


def wait_for_ends(client: httpx.Client, fits: Iterable[str], log: Path) -> None:
    """Returns when every fit has ended; as long as one goes on in time, the others may take longer."""
    left = set(fits)
    states: dict[str, tuple[str, int]] = {}

    def something_happened() -> bool:
        before = dict(states)
        for fit_id in left:
            fit = client.get(f"/api/fits/{fit_id}").json()
            states[fit_id] = (fit["state"], fit["last_event"])
        left.difference_update([fit_id for fit_id in left if states[fit_id][0] in ("done", "failed")])
        return states != before

    while left:
        try:
            until(something_happened, "an event")
        except AssertionError as error:
            told = {fit_id: states[fit_id] for fit_id in left}
            raise AssertionError(f"nothing happened for {PATIENCE_S} s: {told}\n{log.read_text()[-3000:]}") from error


def outcome(client: httpx.Client, data: Path, fits: Iterable[str]) -> Outcome:
    """What is to be seen now of the fits with these ids; all should have ended."""
    counts = dict.fromkeys(("asked", "done", "resumed", "failed", "lost", "doubled"), 0)
    for fit_id in fits:
        counts["asked"] += 1
        answer = client.get(f"/api/fits/{fit_id}")
        if answer.status_code != 200 or answer.json()["state"] in ("queued", "running"):
            counts["lost"] += 1
            continue
        fit = answer.json()
        told = [one["event"] for one in client.get(fit["links"]["events"] + ".json?limit=1000").json()["events"]]
        counts["resumed"] += _attempts(data, fit_id) > 1
        counts["doubled"] += _is_doubled(told)
        if fit["state"] == "done" and _is_whole(client, fit["links"], told):
            counts["done"] += 1
        elif fit["state"] == "failed" and len(fit["reason"]) > 20 and told[-1]["kind"] == "failed":
            counts["failed"] += 1
        else:
            counts["lost"] += 1
    return Outcome(**counts, left_over=len(left_over(data)))


def _is_doubled(told: list[dict]) -> bool:
    kinds = [event["kind"] for event in told]
    iterations = [event["iteration"] for event in told if event["kind"] == "iterated"]
    ends = sum(kind in ("done", "failed", "cancelled") for kind in kinds)
    return kinds.count("started") > 1 or ends != 1 or len(set(iterations)) < len(iterations)


def _is_whole(client: httpx.Client, links: dict[str, str], told: list[dict]) -> bool:
    files = {name: client.get(links[name]) for name in FILES}
    if {answer.status_code for answer in files.values()} != {200}:
        return False
    return bool(json.loads(files["result"].content) == told[-1]["result"])


def fit_folder(data: Path, fit_id: str) -> Path:
    """Wherever the fit lies."""
    (found,) = data.glob(f"cases/*/scans/*/fits/{fit_id}")
    return found


def all_fits(data: Path) -> set[str]:
    return {folder.name for folder in data.glob("cases/*/scans/*/fits/*")}


def _attempts(data: Path, fit_id: str) -> int:
    """How often the fit was begun."""
    file = fit_folder(data, fit_id) / layout.ATTEMPTS
    return file.stat().st_size if file.exists() else 0


def left_over(data: Path) -> list[Path]:
    """Files and folders that belong to no case, and what is on its way in or out."""
    left = [*(data / layout.INCOMING).iterdir(), *(data / layout.RUBBISH).iterdir()]
    cases = data / layout.CASES
    left += [each for each in cases.iterdir() if not (each / layout.CASE).is_file()]
    left += [each for each in cases.glob(f"*/{layout.SCANS}/*") if not (each / layout.SCAN).is_file()]
    left += [each for each in cases.glob(f"*/{layout.SCANS}/*/{layout.FITS}/*") if not (each / layout.FIT).is_file()]
    return [*left, *cases.glob(f"*/{PART}*")]


def lines(rows: list[tuple[str, Outcome]]) -> list[str]:
    """The table for people."""
    names = [field.name.replace("_", "-") for field in fields(Outcome)]
    width = max(len("fault"), *(len(fault) for fault, _ in rows))
    table = [f"{'fault':<{width}}" + "".join(f"{name:>10}" for name in names)]
    for fault, found in rows:
        table.append(f"{fault:<{width}}" + "".join(f"{number:>10}" for number in asdict(found).values()))
    return table
