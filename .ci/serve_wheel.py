"""Installs a wheel into an empty environment and asks the service that it holds for a few pages.

    python serve_wheel.py ENVIRONMENT WHEEL DATA_FOLDER

The programs that run here see a PATH with the environment's own programs and nothing else, so that a page
that secretly needs Node, or a package that was only installed in the developer's environment, shows at once.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

FIT_TIMEOUT_S = 120.0


def get(url: str, body: object = None, token: str = "") -> bytes:
    """The answer to a GET, or to a POST of `body` as JSON."""
    data = None if body is None else json.dumps(body).encode()
    headers = ({"Content-Type": "application/json"} if data else {}) | (
        {"Authorization": f"Bearer {token}"} if token else {}
    )
    request = urllib.request.Request(url, data=data, headers=headers)
    # No proxy: the address is on this machine.  Cookies as a browser keeps them, from the redirect to what follows it.
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}), urllib.request.HTTPCookieProcessor())
    with opener.open(request, timeout=120) as answer:
        return bytes(answer.read())


def ready_address(service: subprocess.Popen[str]) -> tuple[str, str]:
    """(address, token) that the service prints when it is ready."""
    assert service.stdout is not None
    found = re.search(r"(http://\S+)/\?token=(\S+)", service.stdout.readline())
    if found is None:
        raise SystemExit("error: breastrig serve printed no address with a token.")
    return found[1], found[2]


def check_closed(base: str) -> None:
    """Without the token nothing of a patient is answered."""
    try:
        get(f"{base}/api/patients")
    except urllib.error.HTTPError as error:
        if error.code == 401:
            return
        raise
    raise SystemExit("error: patients are shown without a token.")


def check_answers(base: str, token: str) -> None:
    """The page with what it loads, the model and the notice, all from the wheel."""
    page = get(f"{base}/?token={token}").decode()
    assert "<script" in page, "the page has no script"
    assert "BreastRig" in page, "the page does not carry the program's name"
    for quote in ('src="', 'href="'):
        for reference in (part.split('"')[0] for part in page.split(quote)[1:]):
            if not reference.startswith(("data:", "#")):
                assert get(f"{base}/{reference.removeprefix('./').removeprefix('/')}"), f"{reference} is empty"
    meta = json.loads(get(f"{base}/api/meta", token=token))
    assert "Not a medical device" in meta["notice"], "the limits of use are missing"
    assert get(f"{base}/api/models/torso.glb", token=token)[:4] == b"glTF", "the model is no GLB"
    examples = json.loads(get(f"{base}/api/examples", token=token))["examples"]
    assert {"standing", "supine"} <= {example["name"] for example in examples}, "an example is missing"
    print(f"served: BreastRig {meta['version']}, page of {len(page)} bytes, {meta['model']['vertices']} vertices")


def check_fit(base: str, token: str) -> None:
    """The example patient is fitted: workers, model, example and presets all work from the wheel."""
    scan = json.loads(get(f"{base}/api/examples/standing", {}, token))
    landmarks = scan["example_landmarks"]["landmarks"]
    fit = json.loads(get(f"{base}/api/fits", {"scan": scan["id"], "landmarks": landmarks}, token))
    deadline = time.monotonic() + FIT_TIMEOUT_S
    while (state := json.loads(get(f"{base}/api/fits/{fit['id']}", token=token)))["state"] in ("queued", "running"):
        assert time.monotonic() < deadline, "the fit did not end"
        time.sleep(0.2)
    assert state["state"] == "done", state["reason"]
    result = json.loads(get(f"{base}/api/fits/{fit['id']}/result.json", token=token))
    print(f"fitted: {result['iterations']} iterations, {result['surface_distance_mm']['mean']:.2f} mm from the scan")


def install(programs: Path, what: str) -> None:
    """Into the environment of these programs."""
    command = [programs / "python", "-m", "pip", "install", "-qq", what]
    subprocess.run(command, env=os.environ | {"PATH": str(programs)}, check=True)


def main(environment: Path, wheel: Path, data: Path) -> None:
    programs = environment.resolve() / "bin"
    assert shutil.which("node", path=str(programs)) is None
    bare = {"PATH": str(programs), "HOME": str(data.resolve()), "LANG": "C.UTF-8"}
    data.mkdir(parents=True, exist_ok=True)
    install(programs, str(wheel))
    alone = subprocess.run([programs / "breastrig", "serve"], env=bare, capture_output=True, text=True, check=False)
    assert 'pip install "breastrig[server]"' in alone.stderr, alone.stderr
    install(programs, f"{wheel}[server]")
    service = subprocess.Popen(
        [programs / "breastrig", "serve", "--port", "0", "--data", str(data / "data")],
        cwd=data,
        env=bare,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        base, token = ready_address(service)
        check_closed(base)
        check_answers(base, token)
        check_fit(base, token)
    finally:
        service.terminate()
        try:
            service.wait(20)
        except subprocess.TimeoutExpired:
            service.kill()
            raise SystemExit("error: breastrig serve did not stop when asked to.") from None


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:4]))
