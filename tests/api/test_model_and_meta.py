import json
from dataclasses import replace

from flask.testing import FlaskClient
from helpers.problems import problem
from helpers.toy_rig import toy_rig

from breastrig import __version__
from breastrig.api.config import Config
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.gltf.read_rig import read_rig
from breastrig.gltf.write_rig import rig_glb

FOR_EVER = "public, max-age=31536000, immutable"


def test_the_service_says_that_it_lives(client: FlaskClient) -> None:
    answer = client.get("/healthz")
    assert (answer.status_code, answer.json) == (200, {"status": "ok"})


def test_meta_names_version_limits_and_model(client: FlaskClient, config: Config) -> None:
    meta = client.get("/api/meta").json
    assert (meta["name"], meta["version"], meta["notice"]) == ("BreastRig", __version__, LIMITS_OF_USE)
    assert meta["limits"] == {
        "upload_bytes": config.uploads.file_bytes,
        "zip_bytes": config.uploads.zip_bytes,
        "triangles": config.uploads.triangles,
        "keep_days": 30,
    }
    assert {".ply", ".nii", ".nii.gz", ".dcm"} <= set(meta["scan_files"]["endings"])
    assert meta["units"] == ["auto", "m", "dm", "cm", "mm", "in", "ft"]
    assert (meta["model"]["name"], meta["model"]["bones"], meta["model"]["blendshapes"]) == ("toy", 4, 4)
    assert [landmark["name"] for landmark in meta["landmarks"]] == list(toy_rig().landmark_names)
    assert all(set(one) == {"name", "label", "latin", "definition", "easy", "mirror"} for one in meta["landmarks"])
    assert meta["presets"] == ["default", "paper"]
    assert meta["drawings"][0] == {"name": "lumpectomy", "label": "Lumpectomy (toy)"}
    assert [drawing["name"] for drawing in meta["drawings"]] == ["lumpectomy", "periareolar", "ellipse"]
    assert [pattern["name"] for pattern in meta["patterns"]] == [
        "periareolar", "ellipse", "tumour", "tumour_at",
    ]  # fmt: skip  # the toy has no fold


def test_meta_names_the_patterns_of_the_packaged_torso(client_for, config: Config) -> None:
    meta = client_for(replace(config, model=None)).get("/api/meta").json
    patterns = {pattern["name"]: pattern for pattern in meta["patterns"]}
    assert list(patterns) == ["reduction", "vertical", "periareolar", "ellipse", "tumour", "tumour_at"]
    assert patterns["reduction"]["label"] == "Reduction (Wise pattern)"
    assert {"reduction"} & {drawing["name"] for drawing in meta["drawings"]}
    shown = {one["name"]: one for one in patterns["reduction"]["parameters"]}
    about = shown["areola_mm"].pop("about")
    assert "diameter of the new areola" in about
    assert shown["areola_mm"] == {
        "name": "areola_mm",
        "label": "New areola",
        "unit": "mm",
        "default": 42.0,
        "needed": False,
        "min": 30.0,
        "max": 55.0,
        "choices": None,
    }
    assert (shown["side"]["default"], shown["side"]["choices"], shown["side"]["min"]) == (
        "both",
        ["both", "L", "R"],
        None,
    )
    assert (shown["limb_mm"]["default"], shown["limb_mm"]["needed"], shown["limb_mm"]["max"]) == (None, False, 80.0)
    assert shown["opening_deg"]["unit"] == "deg"
    clock = next(one for one in patterns["tumour"]["parameters"] if one["name"] == "clock")
    assert (clock["unit"], clock["needed"], clock["min"], clock["max"]) == ("h", True, 0.5, 12.5)


def test_the_model_is_the_file_on_disk(client: FlaskClient, config: Config) -> None:
    answer = client.get("/api/models/torso.glb")
    assert answer.data == rig_glb(read_rig(config.model)) == config.model.read_bytes()
    assert (answer.mimetype, answer.headers["Cache-Control"]) == ("model/gltf-binary", "no-cache")
    assert client.get("/api/models/torso.glb", headers={"If-None-Match": answer.headers["ETag"]}).status_code == 304
    part = client.get("/api/models/torso.glb", headers={"Range": "bytes=0-3"})
    assert (part.status_code, part.data) == (206, b"glTF")


def test_the_side_file_holds_drawings_and_the_order_of_shapes(client: FlaskClient, config: Config) -> None:
    side = client.get("/api/models/torso.json").json
    on_disk = json.loads(config.model.with_suffix(".json").read_text())
    named = {"drawings": [drawing["name"] for drawing in side["drawings"]]}
    assert {key: side[key] for key in on_disk} | named == on_disk
    assert side["shape_names"] == list(toy_rig().shape_names)
    [drawing] = side["drawings"]
    assert drawing["name"] == "lumpectomy"
    assert [shape["closed"] for shape in drawing["shapes"]] == [False, True]
    assert set(drawing["shapes"][0]["surface_points"][0]) == {"face", "barycentric"}


def test_buffers_are_named_by_their_model_and_never_change(client: FlaskClient) -> None:
    sha256 = client.get("/api/meta").json["model"]["sha256"]
    for place in ("torso.glb", "torso.json", "torso.bin", "drawings/lumpectomy.bin"):
        answer = client.get(f"/api/models/{sha256}/{place}")
        assert answer.status_code == 200
        assert len(answer.data) > 100
        assert answer.headers["Cache-Control"] == FOR_EVER
        problem(client.get(f"/api/models/{'0' * 64}/{place}"), 404)
    assert "mona_lisa" in problem(client.get(f"/api/models/{sha256}/drawings/mona_lisa.bin"), 404)
