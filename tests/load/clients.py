"""Clients that work: upload, fit, follow, read everything, delete, and again."""

import asyncio

import httpx

from load.measured import Measured
from load.viewers import OpenFit, Stage

FILES = ("result", "fitted_glb", "fitted_ply", "drawing", "distances")


async def work(stage: Stage, scan: bytes, landmarks: dict[str, list[float]]) -> None:
    """One client, until the run is over."""
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{stage.port}", timeout=60) as client:
        while not stage.over.is_set():
            try:
                await _once(client, stage, scan, landmarks)
            except (httpx.HTTPError, AssertionError) as error:
                stage.measured.errors.append(f"client: {error!r}"[:300])
                await asyncio.sleep(0.1)


async def _once(client: httpx.AsyncClient, stage: Stage, scan: bytes, landmarks: dict[str, list[float]]) -> None:
    measured = stage.measured
    made = await _call(client, measured, "POST scans", "POST", "/api/scans", 201, files={"file": ("a.ply", scan)})
    links = made.json()["links"]
    await _call(client, measured, "PUT landmarks", "PUT", links["landmarks"], 200, json={"landmarks": landmarks})
    asked = await _call(client, measured, "POST fits", "POST", "/api/fits", 202, json={"scan": made.json()["id"]})
    fit = OpenFit(asked.json()["id"])
    stage.fits.append(fit)
    try:
        with measured.call("fit, queue included"):
            state = await _end(client, asked.json()["links"]["events"])
        assert state == "done", f"a fit is {state}"
        measured.fits += 1
        for name in FILES:
            kind = f"GET {asked.json()['links'][name].rsplit('/', 1)[1]}"
            await _call(client, measured, kind, "GET", asked.json()["links"][name], 200)
        await _call(client, measured, "GET mesh.glb", "GET", links["mesh"], 200)
    finally:
        fit.ended = True
        while fit.viewers:
            await asyncio.sleep(0.01)
        stage.fits.remove(fit)
        await _call(client, measured, "DELETE scan", "DELETE", links["self"], 204)


async def _end(client: httpx.AsyncClient, events: str) -> str:
    """The last kind of a fit's stream."""
    kind = "nothing"
    async with client.stream("GET", events) as answer:
        assert answer.status_code == 200, f"status {answer.status_code} for a stream"
        async for line in answer.aiter_lines():
            if line.startswith("event: "):
                kind = line[7:]
    return kind


async def _call(
    client: httpx.AsyncClient, measured: Measured, kind: str, method: str, address: str, status: int, **more: object
) -> httpx.Response:
    with measured.call(kind):
        answer = await client.request(method, address, **more)
    assert answer.status_code == status, f"{kind}: {answer.status_code} {answer.text[:200]}"
    return answer
