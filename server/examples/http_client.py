"""The HTTP API.

Starts a service on this computer, uploads a scan with its landmarks, follows the fit's events as they are
streamed, and fetches the fitted model. Everything is deleted at the end.
"""

import io
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

import httpx
import trimesh
from PIL import Image

import breastrig


def main() -> Image.Image:
    example = breastrig.example("standing")
    with service() as api:
        with open(example.scan, "rb") as file:
            scan = api.post("/api/scans", files={"file": file}).raise_for_status().json()
        api.put(scan["links"]["landmarks"], json=json.loads(example.landmarks.read_text())).raise_for_status()
        fit = api.post("/api/fits", json={"scan": scan["id"]}).raise_for_status().json()

        with api.stream("GET", fit["links"]["events"]) as stream:
            for line in stream.iter_lines():
                if line.startswith("data: "):
                    event = json.loads(line[6:])
                    print(event["kind"], event.get("mean_distance_mm", ""))
                    if event["kind"] in ("done", "failed", "cancelled"):
                        break

        content = api.get(f"{fit['links']['self']}/fitted.glb").raise_for_status().content
        fitted = trimesh.load(io.BytesIO(content), file_type="glb")
        print("fitted.glb:", ", ".join(fitted.geometry))
        picture = api.get(f"{scan['links']['self']}/thumbnail.png").raise_for_status().content
        api.delete(scan["links"]["self"]).raise_for_status()  # the scan, its fit and every trace of them
    thumbnail = Image.open(io.BytesIO(picture)).convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", thumbnail.size, "white"), thumbnail).convert("RGB")


@contextmanager
def service() -> Iterator[httpx.Client]:
    """A client of a service of its own, with an empty data folder."""
    with tempfile.TemporaryDirectory() as data:
        command = [
            sys.executable,
            "-m",
            "breastrig",
            "serve",
            "--port",
            "0",
            "--data",
            data,
            "--no-browser",
            "--log-requests",
            "no",
        ]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            try:
                said = next(line for line in process.stdout if "token=" in line)
                base, token = re.search(r"(http://\S+?)/?\?token=(\S+)", said).groups()
                with httpx.Client(base_url=base, headers={"Authorization": f"Bearer {token}"}, timeout=60) as client:
                    yield client
            finally:
                process.terminate()


if __name__ == "__main__":
    main().save("http_client.png")
