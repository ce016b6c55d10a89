"""Installs a wheel into an empty environment and asks the service that it holds for a few pages.

    python serve_wheel.py ENVIRONMENT WHEEL DATA_FOLDER

The programs that run here see a PATH with the environment's own programs and nothing else, so that a page
that secretly needs Node, or a package that was only installed in the developer's environment, shows at once.
"""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

START_TIMEOUT_S = 60.0
FIT_TIMEOUT_S = 120.0


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def get(url: str, body: object = None) -> bytes:
    """The answer to a GET, or to a POST of `body` as JSON."""
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(url, data=data, headers={"Content-Type": "application/json"} if data else {})
    # No proxy: the address is on this machine.
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    with opener.open(request, timeout=30) as answer:
        return bytes(answer.read())


def wait_until_healthy(base: str, service: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < deadline:
        if service.poll() is not None:
            raise SystemExit(f"error: breastrig serve ended with exit code {service.returncode}.")
        try:
            if json.loads(get(f"{base}/healthz"))["status"] == "ok":
                return
        except (urllib.error.URLError, ConnectionError, TimeoutError):
            time.sleep(0.2)
    raise SystemExit(f"error: breastrig serve did not answer within {START_TIMEOUT_S:.0f} s.")


def check_answers(base: str) -> None:
    """The page with what it loads, the model and the notice, all from the wheel."""
    page = get(f"{base}/").decode()
    assert "<script" in page, "the page has no script"
    assert "BreastRig" in page, "the page does not carry the program's name"
    for quote in ('src="', 'href="'):
        for reference in (part.split('"')[0] for part in page.split(quote)[1:]):
            if not reference.startswith(("data:", "#")):
                assert get(f"{base}/{reference.removeprefix('./').removeprefix('/')}"), f"{reference} is empty"
    meta = json.loads(get(f"{base}/api/meta"))
    assert "Not a medical device" in meta["notice"], "the limits of use are missing"
    assert get(f"{base}/api/models/torso.glb")[:4] == b"glTF", "the model is no GLB"
    examples = json.loads(get(f"{base}/api/examples"))["examples"]
    assert {"standing", "supine"} <= {example["name"] for example in examples}, "an example is missing"
    print(f"served: BreastRig {meta['version']}, page of {len(page)} bytes, {meta['model']['vertices']} vertices")


def check_fit(base: str) -> None:
    """The example patient is fitted: workers, model, example and presets all work from the wheel."""
    scan = json.loads(get(f"{base}/api/examples/standing", {}))
    landmarks = scan["example_landmarks"]["landmarks"]
    fit = json.loads(get(f"{base}/api/fits", {"scan": scan["id"], "landmarks": landmarks}))
    deadline = time.monotonic() + FIT_TIMEOUT_S
    while (state := json.loads(get(f"{base}/api/fits/{fit['id']}")))["state"] in ("queued", "running"):
        assert time.monotonic() < deadline, "the fit did not end"
        time.sleep(0.2)
    assert state["state"] == "done", state["reason"]
    result = json.loads(get(f"{base}/api/fits/{fit['id']}/result.json"))
    print(f"fitted: {result['iterations']} iterations, {result['surface_distance_mm']['mean']:.2f} mm from the scan")


def main(environment: Path, wheel: Path, data: Path) -> None:
    programs = environment.resolve() / "bin"
    assert shutil.which("node", path=str(programs)) is None
    bare = {"PATH": str(programs), "HOME": str(data.resolve()), "LANG": "C.UTF-8"}
    data.mkdir(parents=True, exist_ok=True)
    subprocess.run(
        [programs / "python", "-m", "pip", "install", "-qq", str(wheel)],
        env=os.environ | {"PATH": str(programs)},
        check=True,
    )
    port = free_port()
    service = subprocess.Popen(
        [programs / "breastrig", "serve", "--host", "127.0.0.1", "--port", str(port), "--data", str(data / "data")],
        cwd=data,
        env=bare,
    )
    try:
        wait_until_healthy(f"http://127.0.0.1:{port}", service)
        check_answers(f"http://127.0.0.1:{port}")
        check_fit(f"http://127.0.0.1:{port}")
    finally:
        service.terminate()
        try:
            service.wait(20)
        except subprocess.TimeoutExpired:
            service.kill()
            raise SystemExit("error: breastrig serve did not stop when asked to.") from None


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:4]))
