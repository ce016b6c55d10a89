"""Whether two folders of fits hold the same, byte for byte, apart from what depends on clock and chance."""

import json
import re
from pathlib import Path


def timeless(file: Path) -> bytes:
    """The file's content without what depends on the clock."""
    content = file.read_bytes()
    if file.name == "result.json":
        document = json.loads(content)
        assert document.pop("timing_s")
        document.pop("patient", None)  # of the command: a random code
        for name in ("timing_s", "patient", "files"):
            document.get("fields", {}).pop(name, None)
        document.get("files", {}).pop("drawing.json", None)  # it names the patient
        return json.dumps(document).encode()
    if file.name == "drawing.json":
        document = json.loads(content)
        document.pop("patient", None)
        return json.dumps(document).encode()
    if file.suffix == ".jsonl":
        return re.sub(rb'"elapsed_s":[0-9.e-]+', b"", content)
    if file.suffix == ".glb":
        length = int.from_bytes(content[12:16], "little")
        document, binary = json.loads(content[20 : 20 + length]), bytearray(content[28 + length :])
        (animation,) = document["animations"]
        assert animation.pop("extras")["elapsed_s"]
        keys = document["accessors"][animation["samplers"][0]["input"]]
        view = document["bufferViews"][keys["bufferView"]]
        start = view.get("byteOffset", 0)
        binary[start : start + view["byteLength"]] = bytes(view["byteLength"])
        del keys["min"], keys["max"]
        return json.dumps(document).encode() + bytes(binary)
    return content


def assert_same_files(a: Path, b: Path) -> None:
    names = sorted(str(file.relative_to(a)) for file in a.rglob("*") if file.is_file())
    assert names == sorted(str(file.relative_to(b)) for file in b.rglob("*") if file.is_file())
    for name in names:
        assert timeless(a / name) == timeless(b / name), name
